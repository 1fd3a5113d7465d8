// glTF's materials, textures, samplers and images. glTF 2.0, 3.8 and 3.9.
#include <fmt/format.h>

#include <map>
#include <set>

#include "core/error.h"
#include "core/host_math.h"
#include "io/file.h"
#include "io/gltf_document.h"
#include "io/image_file.h"
#include "io/scene_model.h"

namespace plumb::io {
namespace {

// A texture of the file, decoded as colours or as numbers.
struct Use {
    std::size_t texture = 0;
    bool srgb = true;
    friend bool operator<(const Use& a, const Use& b) {
        return a.texture != b.texture ? a.texture < b.texture : a.srgb > b.srgb;
    }
};

class MaterialReader {
  public:
    MaterialReader(GltfDocument& document, GltfModel& model) : document_(document), model_(model) {}

    std::vector<TextureCoordinates> read() {
        const JsonValue materials = document_.list("materials");
        std::vector<Slots> slots(materials.size());
        std::vector<TextureCoordinates> coordinates(materials.size());
        for (std::size_t m = 0; m < materials.size(); ++m) {
            model_.materials.push_back(read_material(materials[m], m, slots[m]));
            coordinates[m] = slots[m].coordinates;
        }
        // Textures keep the order of the file, whatever material shows them first.
        std::map<Use, int> index;
        for (const Use& use : uses_) {
            index[use] = int(model_.textures.size());
            model_.textures.push_back(read_texture_of(use));
        }
        for (std::size_t m = 0; m < materials.size(); ++m) {
            Material& material = model_.materials[m];
            if (slots[m].colour) material.texture = index[*slots[m].colour];
            if (slots[m].emission) material.emission_texture = index[*slots[m].emission];
            if (slots[m].normal) material.normal_texture = index[*slots[m].normal];
            if (slots[m].surface) material.surface_texture = index[*slots[m].surface];
        }
        return coordinates;
    }

  private:
    struct Slots {
        std::optional<Use> colour, emission, normal, surface;
        TextureCoordinates coordinates;
        bool has_coordinates = false;
    };

    // A textureInfo: which texture, and how its material's faces show it. The first that is read says so for all.
    std::optional<Use> read_slot(const JsonValue& info, bool srgb, Slots& slots) {
        if (!info) return {};
        const JsonValue textures = document_.list("textures");
        const Use use{*info["index"].required().index(textures.size(), "textures"), srgb};
        if (!textures[use.texture]["source"]) {
            document_.note("a texture whose picture an extension has, or nothing has, is left out");
            return {};
        }
        TextureCoordinates c;
        const JsonValue transform = info["extensions"]["KHR_texture_transform"];
        const JsonValue set = transform["texCoord"] ? transform["texCoord"] : info["texCoord"];
        c.set = int(set.integer(0, 1023, 0));
        const std::vector<double> offset = transform["offset"].numbers({0, 0}, -1e6, 1e6);
        const std::vector<double> scale = transform["scale"].numbers({1, 1}, -1e6, 1e6);
        c.offset = {offset[0], offset[1]}, c.scale = {scale[0], scale[1]};
        c.rotation = transform["rotation"].number(-1e6, 1e6, 0);
        if (slots.has_coordinates && !(c == slots.coordinates)) {
            document_.note("a texture that takes other texture coordinates than its material's first is left out: they share one set");
            return {};
        }
        slots.coordinates = c, slots.has_coordinates = true;
        uses_.insert(use);
        return use;
    }

    Material read_material(const JsonValue& json, std::size_t number, Slots& slots) {
        Material material;
        material.name = json["name"].text(fmt::format("material{}", number));
        const JsonValue pbr = json["pbrMetallicRoughness"];
        const std::vector<double> base = pbr["baseColorFactor"].numbers({1, 1, 1, 1}, 0, 1);
        material.reflectance = glm::vec3(float(base[0]), float(base[1]), float(base[2]));
        material.alpha = float(base[3]);
        slots.colour = read_slot(pbr["baseColorTexture"], true, slots);

        // Emission is a radiance in glTF; a diffuse emitter's exitance is pi times it.
        const std::vector<double> emissive = json["emissiveFactor"].numbers({0, 0, 0}, 0, 1);
        const JsonValue strength = json["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"];
        const double exitance = host::pi * strength.number(0, 1e38, 1);
        for (int c = 0; c < 3; ++c) material.emission[c] = float(emissive[std::size_t(c)] * exitance);
        slots.emission = read_slot(json["emissiveTexture"], true, slots);

        const JsonValue normal = json["normalTexture"];
        slots.normal = read_slot(normal, false, slots);
        material.normal_scale = float(normal["scale"].number(-1e30, 1e30, 1));

        const std::string mode = json["alphaMode"].text("OPAQUE");
        if (mode == "MASK")
            material.alpha_cutoff = float(json["alphaCutoff"].number(0, 1e30, 0.5));
        else if (mode == "BLEND") {
            // Nothing is half there: the nearer of the two is taken.
            material.alpha_cutoff = 0.5f;
            document_.note("what is blended (alphaMode BLEND) is cut out where its alpha is below 0.5, and else opaque");
        }
        else if (mode != "OPAQUE")
            json["alphaMode"].fail("expected OPAQUE, MASK or BLEND");
        read_own(json.own(), material);
        read_microfacets(json, material, slots);
        return material;
    }

    // Materials that write_glb() keeps have none unless they say so, nor have those of another model; glTF's others all do.
    void read_microfacets(const JsonValue& json, Material& material, Slots& slots) {
        const JsonValue pbr = json["pbrMetallicRoughness"], extensions = json["extensions"];
        const bool has_lobes = material.specular != glm::vec3(0) || material.mirror != glm::vec3(0);
        const bool other_model = extensions["KHR_materials_unlit"] || (extensions["KHR_materials_pbrSpecularGlossiness"] && !pbr);
        material.microfacet = json.own()["microfacet"].flag(!has_lobes && !other_model && !own_file_);
        const double metalness = pbr["metallicFactor"].number(0, 1, 1), roughness = pbr["roughnessFactor"].number(0, 1, 1);
        const JsonValue texture = pbr["metallicRoughnessTexture"];
        if (!material.microfacet) return;
        if (has_lobes) json.own()["microfacet"].fail("stands beside specular or mirror; expected one or the other");
        material.metalness = float(metalness), material.roughness = float(roughness);
        slots.surface = read_slot(texture, false, slots);
    }

    // extras/plumb: what write_glb() keeps there.
    static void read_own(const JsonValue& own, Material& material) {
        const auto colour = [&](const char* key) {
            const std::vector<double> n = own[key].numbers({0, 0, 0}, 0, 1);
            return glm::vec3(float(n[0]), float(n[1]), float(n[2]));
        };
        material.specular = colour("specular"), material.mirror = colour("mirror");
        material.exponent = float(own["exponent"].number(0, max_exponent, double(material.exponent)));
        const std::string excess = excess_of(material);
        if (!excess.empty()) own.fail(excess);
    }

    static Wrap read_wrap(const JsonValue& json) {
        switch (json.integer(0, 65535, 10497)) {
            case 10497:
                return Wrap::repeat;
            case 33648:
                return Wrap::mirrored_repeat;
            case 33071:
                return Wrap::clamp_to_edge;
            default:
                json.fail("expected 10497 (repeat), 33648 (mirrored repeat) or 33071 (clamp to edge)");
        }
    }

    Texture read_texture_of(const Use& use) {
        const JsonValue json = document_.list("textures")[use.texture];
        const std::size_t number = *json["source"].required().index(document_.list("images").size(), "images");
        Texture texture = read_image(number);
        texture.name = json["name"].text(texture.name);
        texture.srgb = json.own()["srgb"].flag(use.srgb);
        texture.mips = json.own()["mips"].flag(false);
        const JsonValue samplers = document_.list("samplers");
        const std::optional<std::size_t> index = json["sampler"].index(samplers.size(), "samplers");
        if (!index) return texture;
        const JsonValue sampler = samplers[*index];
        const std::uint64_t magnify = sampler["magFilter"].integer(0, 65535, 9729);
        if (magnify != 9728 && magnify != 9729) sampler["magFilter"].fail("expected 9728 (nearest) or 9729 (linear)");
        texture.filter = magnify == 9728 ? Filter::nearest : Filter::bilinear;
        texture.wrap_u = read_wrap(sampler["wrapS"]);
        texture.wrap_v = read_wrap(sampler["wrapT"]);
        return texture;
    }

    // Decodes an image once, however many textures show it.
    const Texture& read_image(std::size_t number) {
        const auto known = images_.find(number);
        if (known != images_.end()) return known->second;
        const JsonValue json = document_.list("images")[number], uri = json["uri"], view = json["bufferView"];
        if (bool(uri) == bool(view)) json.fail("expected either uri or bufferView");
        std::string place = shown(document_.path) + ": " + (uri ? uri : view).pointer(), name;
        std::vector<unsigned char> bytes;
        if (view) {
            const ByteSpan span = view_bytes(document_, view);
            bytes.assign(span.data, span.data + span.size);
        } else {
            const std::string text = uri.text();
            std::optional<std::vector<unsigned char>> data = decode_data_uri(uri, text);
            if (!data) {
                const std::string file = file_of_uri(document_, uri, text);
                name = file.substr(folder_of(file).empty() ? 0 : folder_of(file).size() + 1);
                try {
                    data = read_bytes(file);
                } catch (const InputError& e) {
                    throw InputError(place + ": " + e.what());
                }
                place += ": " + shown(file);
            }
            bytes = std::move(*data);
        }
        if (bytes.empty()) throw InputError(place + ": is empty; expected a picture");
        Texture texture = decode_texture(place, bytes);
        texture.name = json["name"].text(name.empty() ? fmt::format("image{}", number) : name);
        return images_[number] = std::move(texture);
    }

    GltfDocument& document_;
    GltfModel& model_;
    const bool own_file_ = document_.list("asset")["generator"].text("") == own_generator;
    std::set<Use> uses_;
    std::map<std::size_t, Texture> images_;
};

}  // namespace

std::vector<TextureCoordinates> read_gltf_materials(GltfDocument& document, GltfModel& model) {
    return MaterialReader(document, model).read();
}

}  // namespace plumb::io
