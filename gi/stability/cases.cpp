#include "gi/stability/cases.h"

#include "gi/stability/cases_parts.h"

namespace plumb::stability {

const std::vector<Case>& cases() {
    static const std::vector<Case> all = [] {
        std::vector<Case> list = {{"room", "room", "nothing is extreme: what the others are held against", room}};
        for (const auto& group : {extent_cases, geometry_cases, light_cases, frame_cases, edited_cases})
            for (Case& c : group()) list.push_back(std::move(c));
        return list;
    }();
    return all;
}

frame::Settings case_settings(const Case& c, const Scene& scene) {
    frame::Settings settings = frame::settings_of(scene);
    settings.rsm.samples = 50;
    settings.indirect.blur = filter::Blur::none;  // filters have cells of their own
    if (c.settings) c.settings(settings);
    return settings;
}

}  // namespace plumb::stability
