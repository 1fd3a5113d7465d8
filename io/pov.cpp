#include "io/pov.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/camera.h"
#include "core/error.h"
#include "core/flip.h"
#include "core/host_math.h"
#include "io/file.h"

namespace plumb::io {
namespace {

double length(const glm::dvec3& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }
glm::dvec3 cross3(const glm::dvec3& a, const glm::dvec3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class Vec>
bool finite(const Vec& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// The shortest decimals that read back as the same number, for floats and doubles.
template <class Vec>
std::string vector(const Vec& v) {
    return fmt::format("<{},{},{}>", v.x, v.y, v.z);
}

// A comment of one line.
std::string comment(const std::string& text) { return "// " + printable(text, 200) + "\n"; }

// ---- what is not shown as it is ---------------------------------------------------------------------------------------

// The mean of a texture's texels, linear; alpha is left aside.
glm::dvec3 mean_of(const Texture& texture) {
    double decode[256];
    for (int i = 0; i < 256; ++i) decode[i] = texture.srgb ? compare::srgb_to_linear(i / 255.0) : i / 255.0;
    std::int64_t counts[3][256] = {};
    for (const std::uint32_t texel : texture.texels.texels)
        for (int c = 0; c < 3; ++c) ++counts[c][(texel >> (8 * c)) & 255];
    glm::dvec3 sum(0);
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < 256; ++i) sum[c] += double(counts[c][i]) * decode[i];
    return texture.texels.size() > 0 ? sum / double(texture.texels.size()) : glm::dvec3(1);
}

// The integral of sin over a row's share of polar angles: its band, or its tents where rows are interpolated, which are 1
// to the poles at the first and the last. int_0^h (1 - y/h) sin(a + y) dy = cos a - (sin(a + h) - sin a)/h.
double row_weight(int y, int height, bool bilinear) {
    const double h = host::pi / height, a = (y + 0.5) * h;
    if (!bilinear) return host::cos(host::pi * y / height) - host::cos(host::pi * (y + 1) / height);
    const double above = y == 0 ? 1 - host::cos(a) : (host::sin(a) - host::sin(a - h)) / h - host::cos(a);
    const double below = y == height - 1 ? 1 + host::cos(a) : host::cos(a) - (host::sin(a + h) - host::sin(a)) / h;
    return above + below;
}

// Over all directions.
glm::dvec3 mean_of(const Environment& environment) {
    const Image4& map = environment.map;
    glm::dvec3 sum(0);
    for (int y = 0; y < map.height; ++y) {
        glm::dvec3 row(0);
        for (int x = 0; x < map.width; ++x) row += glm::dvec3(map(x, y));
        sum += row * (row_weight(y, map.height, environment.filter == Filter::bilinear) / 2 / map.width);
    }
    return sum;
}

struct Replaced {
    int textures = 0, normal_maps = 0, masks = 0, glossy = 0;
    bool map = false;
};

// Replaces and counts.
Replaced replace(Scene& scene) {
    Replaced r;
    std::vector<glm::dvec3> means;
    for (const Texture& texture : scene.textures) means.push_back(mean_of(texture));
    auto take = [&](int& index, glm::vec3& value) {
        if (index < 0) return;
        value = glm::vec3(glm::dvec3(value) * means.at(std::size_t(index)));
        index = -1, ++r.textures;
    };
    for (Material& m : scene.materials) {
        take(m.texture, m.reflectance);
        take(m.emission_texture, m.emission);
        r.normal_maps += m.normal_texture >= 0, m.normal_texture = -1;
        r.masks += m.alpha_cutoff > 0, m.alpha_cutoff = 0, m.alpha = 1;
        r.glossy += m.microfacet || m.specular != glm::vec3(0) || m.mirror != glm::vec3(0);
        m.specular = m.mirror = glm::vec3(0);
    }
    scene.textures.clear();
    r.map = !scene.environment.map.empty();
    glm::vec3& radiance = scene.environment.radiance;
    if (r.map) radiance = glm::vec3(glm::dvec3(radiance) * mean_of(scene.environment));
    scene.environment.map = {};
    return r;
}

// ---- checks -----------------------------------------------------------------------------------------------------------

void check(const Scene& scene, const PovOptions& options, glm::ivec2 size) {
    if (size.x < 1 || size.y < 1)
        throw InputError(fmt::format("pov: size = {} x {}: expected at least 1 x 1", size.x, size.y));
    if (options.bounces < 1 || options.bounces > 20)
        throw InputError(fmt::format("pov: bounces = {}: expected 1 to 20, POV-Ray's limit", options.bounces));
    if (options.samples < 1 || options.samples > 1600)
        throw InputError(fmt::format("pov: samples = {}: expected 1 to 1600, POV-Ray's limit", options.samples));
    validate(scene.camera);
    for (const Light& light : scene.lights) {
        const std::string what = fmt::format("pov: {}: light \"{}\": ", scene.name, printable(light.name));
        if (!finite(light.position) || !finite(light.direction) || !finite(light.intensity))
            throw InputError(what + "expected finite numbers");
        if (light.type != LightType::point && !(length(glm::dvec3(light.direction)) > 1e-30))
            throw InputError(what + "direction: expected a vector with a length");
    }
    for (const Material& m : scene.materials)
        if (!finite(m.reflectance) || !finite(m.emission))
            throw InputError(fmt::format("pov: {}: material \"{}\": expected finite numbers", scene.name, printable(m.name)));
    if (!finite(scene.environment.radiance))
        throw InputError(fmt::format("pov: {}: environment: expected finite numbers", scene.name));
}

glm::ivec2 size_of(const Scene& scene, const PovOptions& options) {
    return options.size == glm::ivec2(0) ? scene.frame_size : options.size;
}

// ---- the script -------------------------------------------------------------------------------------------------------

// Scene is one that replace() has been through.
class Writer {
  public:
    Writer(const Scene& scene, const PovOptions& options)
        : scene_(scene), options_(options), geometry_(flatten(scene)) {
        bounds(geometry_, low_, high_);
        for (const Vertex& v : geometry_.vertices)
            if (!finite(v.position) || !finite(v.normal))
                throw InputError(fmt::format("pov: {}: a vertex is not finite", scene.name));
        extent_ = std::max(length(glm::dvec3(high_) - glm::dvec3(low_)), 1e-6);
    }

    std::string text(const std::vector<std::string>& notes) {
        out_ = "#version 3.7;\n";
        out_ += comment("Scene \"" + scene_.name + "\". Pixels are radiance, W/(m2 sr).");
        for (const std::string& note : notes) out_ += comment(note);
        settings();
        camera();
        for (const Light& light : scene_.lights)
            if (light.on && light.intensity != glm::vec3(0)) lamp(light);
        for (std::size_t i = 0; i < scene_.materials.size(); ++i) material(i);
        meshes();
        return std::move(out_);
    }

  private:
    void settings() {
        out_ += "global_settings {\n  assumed_gamma 1.0\n  max_trace_level 30\n";
        if (options_.preset == PovPreset::published)
            out_ += fmt::format("  radiosity {{\n    brightness {}\n", options_.brightness) +
                    "    pretrace_start 0.08\n    pretrace_end 0.01\n    count 250\n"
                    "    error_bound 0.25\n    recursion_limit 2\n  }\n";
        if (options_.preset == PovPreset::physical)
            out_ += fmt::format("  radiosity {{\n    brightness 1\n    pretrace_start 0.08\n    pretrace_end 0.01\n"
                                "    count {}\n    error_bound 0.2\n    low_error_factor 0.5\n    nearest_count 10\n"
                                "    minimum_reuse 0.01\n    recursion_limit {}\n    adc_bailout 1e-9\n"
                                "    gray_threshold 0\n    normal off\n    media off\n  }}\n",
                                options_.samples, options_.bounces);
        out_ += "}\n#default { finish { ambient 0 diffuse 1 emission 0 specular 0 phong 0 reflection 0 } }\n";
        out_ += "background { rgb " + vector(scene_.environment.radiance) + " }\n";
    }

    // right x up points at the viewer, as in our space; POV-Ray's default camera is the mirrored one. up and right span
    // the picture at the distance |direction|: no angle is taken from them.
    void camera() {
        const glm::ivec2 size = size_of(scene_, options_);
        const CameraAxes a = axes(scene_.camera);
        const double height = 2 * host::tan(scene_.camera.fov_y_deg * (host::pi / 360));
        out_ += "camera {\n  perspective\n  location " + vector(scene_.camera.position) + "\n  direction " +
                vector(a.forward) + "\n  up " + vector(a.up * height) + "\n  right " +
                vector(a.right * (height * size.x / size.y)) + "\n}\n";
    }

    // A light that ends at its radius r, ISR (16), sends 1 - (d / r)^2, and POV-Ray knows 2 / (1 + (d / f)^p) alone. A sum of such
    // fadings of one lamp's place comes near it: each falls where it stands. README.md has its error.
    struct Fading {
        double share, at, power;  // at: f over r
    };
    static constexpr Fading ending[] = {{0.0685, 0.1101, 1.834},
                                         {0.1830, 0.3909, 6.042},
                                         {0.3765, 0.6422, 9.055},
                                         {1.7661, 0.9771, 13.796},
                                         {-1.3827, 1.0089, 14.864}};

    // A surface across the rays of a light of colour c has the radiance rho c, without 1/pi. fade_distance f and
    // fade_power 2 make of it 2 c / (1 + (d/f)^2), which for d >> f is 2 c f^2 / d^2.
    void lamp(const Light& light) {
        out_ += comment("light " + light.name);
        const glm::dvec3 intensity(light.intensity);
        if (light.type == LightType::directional) {
            const glm::dvec3 d = glm::dvec3(light.direction) / length(glm::dvec3(light.direction));
            const glm::dvec3 centre = (glm::dvec3(low_) + glm::dvec3(high_)) * 0.5;
            out_ += "light_source {\n  " + vector(centre - d * (2 * extent_)) + " rgb " + vector(intensity / host::pi) +
                    "\n  parallel point_at " + vector(centre) + "\n" + shadowless() + "}\n";
            return;
        }
        if (light.radius > 0) {
            for (const Fading& f : ending) faded(light, intensity * (f.share / (2 * host::pi)), light.radius * f.at, f.power);
            return;
        }
        const double fade = extent_ * fade_share;
        faded(light, intensity / (2 * host::pi * fade * fade), fade, 2);
    }
    // Of colour 2 c / (1 + (d / distance)^power) at the distance d.
    void faded(const Light& light, const glm::dvec3& c, double distance, double power) {
        const glm::dvec3 position(light.position);
        out_ += "light_source {\n  " + vector(position) + " rgb " + vector(c) +
                fmt::format("\n  fade_distance {} fade_power {}\n", distance, power);
        // Both are half angles, and the falloff between them is smoothstep of the cosine, as ours.
        if (light.type == LightType::spot)
            out_ += fmt::format("  spotlight radius {} falloff {} tightness 0 point_at {}\n", light.cone_inner_deg,
                                light.cone_outer_deg, vector(position + glm::dvec3(light.direction) * extent_));
        out_ += shadowless() + "}\n";
    }
    std::string shadowless() const { return options_.shadowless ? "  shadowless\n" : ""; }

    // What a surface emits is emission times pigment: where it emits and reflects nothing the pigment is the least that
    // leaves the reflectance as it is.
    void material(std::size_t i) {
        const Material& m = scene_.materials[i];
        glm::vec3 pigment = m.reflectance;
        glm::dvec3 emission(0);
        for (int c = 0; c < 3; ++c) {
            if (!(m.emission[c] > 0)) continue;
            pigment[c] = std::max(pigment[c], least_pigment);
            emission[c] = m.emission[c] / (host::pi * pigment[c]);
        }
        out_ += comment("material " + m.name);
        out_ += fmt::format("#declare material_{} = texture {{ pigment {{ rgb {} }}", i, vector(pigment));
        if (emission != glm::dvec3(0)) out_ += " finish { emission rgb " + vector(emission) + " }";
        out_ += " }\n";
    }

    bool degenerate(const glm::uvec3& t) const {
        const glm::dvec3 a(geometry_.vertices[t.x].position), b(geometry_.vertices[t.y].position),
            c(geometry_.vertices[t.z].position);
        return !(length(cross3(b - a, c - a)) > 0);
    }

    void meshes() {
        std::map<std::pair<std::int32_t, std::int32_t>, std::vector<std::size_t>> groups;  // by object and material
        for (std::size_t t = 0; t < geometry_.triangles.size(); ++t)
            if (!degenerate(geometry_.triangles[t])) groups[{geometry_.object[t], geometry_.material[t]}].push_back(t);
        place_of_.assign(geometry_.vertices.size(), -1);
        for (const auto& [key, triangles] : groups) mesh(key.first, key.second, triangles);
    }

    void mesh(std::int32_t object, std::int32_t material, const std::vector<std::size_t>& triangles) {
        std::vector<std::uint32_t> used;
        std::string faces;
        for (const std::size_t t : triangles) {
            int place[3];
            for (int k = 0; k < 3; ++k) {
                const std::uint32_t v = geometry_.triangles[t][k];
                if (place_of_[v] < 0) place_of_[v] = int(used.size()), used.push_back(v);
                place[k] = place_of_[v];
            }
            faces += fmt::format(",\n<{},{},{}>", place[0], place[1], place[2]);
        }
        std::string positions, normals;
        for (const std::uint32_t v : used) {
            positions += ",\n" + vector(geometry_.vertices[v].position);
            normals += ",\n" + vector(geometry_.vertices[v].normal);
            place_of_[v] = -1;
        }
        out_ += comment("mesh " + scene_.meshes[std::size_t(object)].name);
        out_ += fmt::format("mesh2 {{\n  vertex_vectors {{ {}{} }}\n  normal_vectors {{ {}{} }}\n", used.size(),
                            positions, used.size(), normals);
        out_ += fmt::format("  face_indices {{ {}{} }}\n  normal_indices {{ {}{} }}\n", triangles.size(), faces,
                            triangles.size(), faces);
        out_ += material >= 0 ? fmt::format("  texture {{ material_{} }}\n}}\n", material)
                              : std::string("  pigment { rgb 0 }\n}\n");
    }

    static constexpr double fade_share = 1e-6;     // of the scene's extent: 1/d^2 is off by (f / d)^2
    static constexpr float least_pigment = 1e-6f;

    const Scene& scene_;
    const PovOptions& options_;
    Geometry geometry_;
    glm::vec3 low_{0}, high_{0};
    double extent_ = 1;
    std::vector<int> place_of_;  // of each vertex in the mesh that is being written; -1: not there yet
    std::string out_;
};

std::vector<std::string> notes_of(const Replaced& r, const Scene& scene, const PovOptions& options) {
    std::vector<std::string> notes;
    auto note = [&](int count, const char* text) {
        if (count > 0) notes.push_back(fmt::format("{} {}", count, text));
    };
    note(r.textures, "textures of materials are replaced by their mean");
    note(r.normal_maps, "normal maps are left out");
    note(r.masks, "masked materials are solid");
    note(r.glossy, "materials reflect their diffuse part alone");
    if (r.map) notes.push_back("the environment map is replaced by its mean");
    for (const Light& light : scene.lights)
        if (light.on && light.radius > 0) {
            notes.push_back("lights that end at a radius are sums of fadings: within 1.5 % of what such a light sends at its place");
            break;
        }
    if (options.preset == PovPreset::published && options.brightness != 1)
        notes.push_back(fmt::format("brightness {} multiplies light at every gather: the picture is not physical", options.brightness));
    if (options.preset == PovPreset::direct) {
        bool emits = false;
        for (const Material& m : scene.materials) emits = emits || m.emission != glm::vec3(0);
        if (emits || scene.environment.radiance != glm::vec3(0))
            notes.push_back("without radiosity surfaces that emit, and the environment, are seen but light nothing");
    }
    return notes;
}

bool is_plain(const std::string& word) {
    return !word.empty() && std::all_of(word.begin(), word.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               std::string_view("+-_./,:@%").find(c) != std::string_view::npos;
    });
}

// In single quotes where a shell would read more than letters in it.
std::string shell_word(const std::string& word) {
    if (is_plain(word)) return word;
    std::string out = "'";
    for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out + "'";
}

// POV-Ray takes its arguments apart once more: a space ends one, quotes of either kind hold one together.
std::string option(const std::string& letter, const std::string& path) {
    if (is_plain(path)) return letter + path;
    for (const char quote : {'"', '\''})
        if (path.find(quote) == path.npos) return letter + quote + path + quote;
    throw InputError("pov: " + shown(path) + ": POV-Ray takes no path with both kinds of quotes");
}

}  // namespace

Scene pov_scene(const Scene& scene) {
    Scene shown = scene;
    replace(shown);
    return shown;
}

std::vector<std::string> pov_notes(const Scene& scene, const PovOptions& options) {
    Scene shown = scene;
    const Replaced replaced = replace(shown);
    return notes_of(replaced, shown, options);
}

std::string pov_text(const Scene& scene, const PovOptions& options) {
    check(scene, options, size_of(scene, options));
    Scene shown = scene;
    const Replaced replaced = replace(shown);
    return Writer(shown, options).text(notes_of(replaced, shown, options));
}

void write_pov(const std::string& path, const Scene& scene, const PovOptions& options) {
    write_text(path, pov_text(scene, options));
}

std::vector<std::string> povray_command(const std::string& script, const std::string& picture, glm::ivec2 size) {
    return {"povray", option("+I", script), option("+O", picture), "+FE", fmt::format("+W{}", size.x),
            fmt::format("+H{}", size.y), "-A", "-D", "+WT1"};
}

std::string povray_command_line(const std::string& script, const std::string& picture, glm::ivec2 size) {
    std::string line;
    for (const std::string& word : povray_command(script, picture, size))
        line += (line.empty() ? "" : " ") + shell_word(word);
    return line;
}

}  // namespace plumb::io
