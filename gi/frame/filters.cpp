#include "gi/frame/filters.h"

namespace plumb::frame {

namespace {

bool is_last(const Settings& settings, const PlannedStage& stage) {
    const std::vector<FilterStage> after = filters_after_gathers(settings);
    return !after.empty() && after.back().name == stage.name && after.back().form == stage.form;
}

}  // namespace

bool halves_indirect(const Settings& settings) {
    return settings.method == Method::rsm && settings.indirect.resolution == filter::Resolution::half;
}

bool filters_indirect(const Settings& settings) {
    return halves_indirect(settings) ||
           (settings.method == Method::rsm && settings.indirect.blur != filter::Blur::none);
}

std::vector<FilterStage> filters_before_gathers(const Settings& settings) {
    if (!halves_indirect(settings)) return {};
    return {{"filter.reduce", "position"}, {"filter.reduce", "normal"}};
}

std::vector<FilterStage> filters_after_gathers(const Settings& settings) {
    std::vector<FilterStage> stages;
    if (!filters_indirect(settings)) return stages;
    if (halves_indirect(settings)) stages.push_back({"filter.upsample", ""});
    if (settings.indirect.blur == filter::Blur::full) stages.push_back({"filter.blur", ""});
    if (settings.indirect.blur != filter::Blur::separable) return stages;
    stages.push_back({"filter.blur", "horizontal"});
    stages.push_back({"filter.blur", "vertical"});
    return stages;
}

bool is_filter(const std::string& stage) { return stage.rfind("filter.", 0) == 0; }

glm::ivec2 gather_size(const Settings& settings, glm::ivec2 frame_size) {
    return halves_indirect(settings) ? filter::half_size(frame_size) : frame_size;
}

glm::ivec2 stage_size(const Settings& settings, const PlannedStage& stage, glm::ivec2 frame_size) {
    return is_gather(stage.name) || stage.name == "filter.reduce" ? gather_size(settings, frame_size) : frame_size;
}

std::string filter_place(const Settings& settings, const PlannedStage& stage) {
    if (stage.name == "filter.reduce") return "half_" + stage.form;
    if (is_last(settings, stage)) return "indirect";
    return stage.name == "filter.upsample" ? "upsampled" : "blurred_across";
}

Image4& filter_result(Frame& frame, const Settings& settings, const PlannedStage& stage) {
    const std::string place = filter_place(settings, stage);
    if (place == "half_position") return frame.half_position;
    if (place == "half_normal") return frame.half_normal;
    if (place == "upsampled") return frame.upsampled;
    return place == "blurred_across" ? frame.blurred_across : frame.indirect;
}

const Image4& filter_result(const Frame& frame, const Settings& settings, const PlannedStage& stage) {
    return filter_result(const_cast<Frame&>(frame), settings, stage);
}

const Image4& reduce_input(const Frame& frame, const PlannedStage& stage) {
    return stage.form == "position" ? frame.gbuffer.position : frame.gbuffer.normal;
}

filter::UpsampleInputs upsample_inputs(const Frame& frame) {
    return {&frame.gathered, &frame.half_position, &frame.half_normal, &frame.gbuffer.position, &frame.gbuffer.normal};
}

filter::BlurInputs blur_inputs(const Settings& settings, const Frame& frame, const PlannedStage& stage) {
    filter::BlurInputs in{halves_indirect(settings) ? &frame.upsampled : &frame.gathered, &frame.gbuffer.position,
                          &frame.gbuffer.normal};
    if (stage.form == "horizontal") in.direction = filter::Direction::horizontal;
    if (stage.form == "vertical") in.direction = filter::Direction::vertical, in.irradiance = &frame.blurred_across;
    return in;
}

raster::Covered covered_by(const Image4& normal) {
    raster::Covered tiles({normal.width, normal.height});
    for (int y = 0; y < normal.height; ++y)
        for (int x = 0; x < normal.width; ++x)
            if (glm::vec3(normal(x, y)) != glm::vec3(0))
                tiles.any[std::size_t(y >> raster::Covered::shift) * std::size_t(tiles.tiles.x) +
                          std::size_t(x >> raster::Covered::shift)] = 1;
    return tiles;
}

}  // namespace plumb::frame
