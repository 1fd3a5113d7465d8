#include "gi/uniform_words.h"

#include <algorithm>

namespace plumb {

namespace {

struct Folder {
    std::string path;  // of its twins
    std::vector<StageWords> stages;
};

const std::vector<Folder>& folders() {
    static const std::vector<Folder> all = {
        {"gi/compose/", compose::uniform_words()},     {"gi/ddgi/", ddgi::uniform_words()},
        {"gi/direct/", direct::uniform_words()},       {"gi/filter/", filter::uniform_words()},
        {"gi/isr/", isr::uniform_words()},             {"gi/probes/", probes::uniform_words()},
        {"gi/radiosity/", radiosity::uniform_words()}, {"raster/", raster::uniform_words()},
        {"gi/rsm/", rsm::uniform_words()},             {"gi/screen/", screen::uniform_words()},
        {"gi/zbuffer/", zbuffer::uniform_words()},
    };
    return all;
}

// What blocks share. A light's map, where a point falls on it: raster/project_kernel.h.
const std::vector<UniformWords>& shared() {
    static const std::vector<UniformWords> words = {
        {"width", "", "of what is written, items; the stage's size gives it"},
        {"height", "", "of what is written, items; the stage's size gives it"},
        {".to_texel_x", "", "row that takes (x, 1), world, to texels of the map, before the division by the row w; a view_proj gives it"},
        {".to_texel_y", "", "the same of y, which grows downwards"},
        {".to_texel_w", "", "row of w: the clip space's, m in front of the light"},
        {".least_w", "m", "floor of w", "1e-6: what is behind the light falls far outside of the map", 1e-6},
        {".low", "texels", "what x and y of the projection are held above", "-1048576: nothing is held", -1048576},
        {".high", "texels", "and below; 0 and size - 1/2 clamp to the map", "1048576", 1048576},
        {".size", "texels", "side of the map; the map's images give it"},
    };
    return words;
}

const UniformWords* find(const std::vector<UniformWords>& words, const std::string& member) {
    const std::size_t dot = member.find('.');
    const std::string inner = dot == std::string::npos ? member : member.substr(dot);
    const auto at = std::find_if(words.begin(), words.end(), [&](const UniformWords& w) {
        return w.member == member || (!inner.empty() && inner[0] == '.' && w.member == inner);
    });
    return at == words.end() ? nullptr : &*at;
}

}  // namespace

const UniformWords* words_of(const StageBinding& binding, const std::string& member) {
    for (const Folder& folder : folders()) {
        if (!binding.twin.starts_with(folder.path)) continue;
        for (const bool own : {true, false})
            for (const StageWords& s : folder.stages)
                if (own ? s.stage == binding.info.name : s.stage.empty())
                    if (const UniformWords* words = find(s.members, member)) return words;
    }
    return find(shared(), member);
}

}  // namespace plumb
