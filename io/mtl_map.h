// Pictures of a material library: how its lines name them, and their texels. Private to io/.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "core/scene.h"
#include "io/mtl.h"

namespace plumb::io {

// "map_Kd -s 2 2 -clamp on bark.png".
struct MtlMap {
    std::string key;     // map_Kd
    std::int64_t line = 0;
    std::string file;    // "": none is named
    Mapping mapping;
    bool clamp = false;
    std::string unread;  // options that would change the picture and are not read: "-mm, -t"
};

// Throws InputError where an option lacks its number.
MtlMap parse_map(const std::string& path, std::int64_t line, std::string_view key, std::string_view rest);

// Gives a model the textures of its libraries, each once.
class MtlMaps {
  public:
    MtlMaps(const std::string& path, const std::string& second_folder, std::vector<Texture>& textures, Findings& findings)
        : path_(path), second_folder_(second_folder), textures_(textures), findings_(findings) {}

    // Index of the texture; -1 where there is no such picture, which goes to the findings. Throws InputError for a picture
    // that is there and damaged.
    int colour(const MtlMap& map);
    // The colours of `map` (white where it names no file, or one that is missing) with the alpha of `mask`, of the size of the
    // colours; -1 where there is no mask.
    int masked(const MtlMap& map, const MtlMap& mask);
    // A map of normals; -1 also where the picture's colours are not those of one: it is of heights.
    int normals(const MtlMap& map, bool& heights);

  private:
    int keep(const std::string& key, const MtlMap& map, Texture texture);

    const std::string& path_;
    const std::string& second_folder_;
    std::vector<Texture>& textures_;
    Findings& findings_;
    std::map<std::string, int> known_;       // by use, file and wrap
    std::map<std::string, Texture> loaded_;  // by path
    std::string loaded(const MtlMap& map);   // the path of a picture that is there, read into loaded_; "": none
};

}  // namespace plumb::io
