#include "gi/frame/presets.h"

#include <fmt/format.h>

#include <glm/glm.hpp>

#include "core/error.h"
#include "core/nearest_known.h"

namespace plumb::frame {

namespace {

using Rows = std::vector<Setting>;

Setting row(std::string table, std::string key, FieldValue value) {
    return {std::move(table), std::move(key), std::move(value), ""};
}
FieldValue word(const char* text) { return std::string(text); }

Rows joined(Rows rows, const Rows& more) {
    rows.insert(rows.end(), more.begin(), more.end());
    return rows;
}

// Bang 2011, Improved Reflective Shadow Maps with Visibility Approximation. What the document leaves open says so.
Rows vrsm() {
    return {
        row("render", "method", word("rsm")),
        row("render", "layout", word("vrsm")),           // 4.2 to 4.4: RGBA16F, linear depth in alpha
        row("rsm", "gather", word("paths")),             // 3.2, Algorithms 1 and 5
        row("rsm", "variant", word("corrected")),
        // rsm.radius, how far paths reach, is open and a length of the map: the scene's.
        row("rsm", "directions", 15.0),                  // 4.4
        row("rsm", "steps", 10.0),
        row("rsm", "spacing", word("geometric")),        // 3.2 has density fall and weights grow by squares, which is geometric;
        row("rsm", "growth", 64.0),                      // by how much is open
        row("rsm", "jitter", 1.0),                       // Algorithm 1, line 5; how slightly is open
        row("rsm", "turn_jitter", 0.0),                  // line 4: with it a path would be no line of sight
        row("rsm", "turn", word("hash")),                // 3.2
        row("rsm", "rotations", 64.0),                   // open
        row("rsm", "visibility", word("algorithm_6")),   // 4.4
        row("rsm", "slots", 5.0),                        // 3.3, 4.4
        row("rsm", "slot_edges", word("angle")),         // 3.3
        row("rsm", "fade", 0.0),                         // ours, and of clamped projections
        row("rsm", "thickness", 0.0),                    // 3.3: a sample fills its own slot
        row("rsm", "texels", word("continuous")),        // Algorithm 1, lines 6 to 10
        row("rsm", "projection", word("plain")),         // Algorithm 1, line 9
        row("rsm", "sample_area", word("none")),         // 3.1: pixel lights are infinitely small
        row("rsm", "min_distance", 0.0),                 // (3.2) has none
        row("indirect", "resolution", word("half")),     // 4.4, 5.1
        row("indirect", "upsample", word("published")),  // 4.5; how is open
        row("indirect", "blur", word("full")),           // 4.5; 17 x 17 or rows and columns is open
        row("indirect", "kernel", 17.0),                 // 4.5, 5.3
        row("indirect", "similarity", word("depth")),    // 4.5
        row("indirect", "sigma_distance", 3.0),          // open, as the next two
        row("indirect", "sigma_depth", 0.02),
        row("indirect", "sigma_normal", 0.3),
        row("shadow", "mode", word("density")),          // 4.3, Algorithm 4
        row("shadow", "variant", word("corrected")),
        row("shadow", "test", word("depth")),            // Algorithm 4
        row("shadow", "kernel", 4.0),                    // 4.3, a tiny kernel; even, as the loop's limits ask
        row("shadow", "bias", 0.001),                    // 4.3; open. Constant there: as `published` has it
        row("shadow", "slope_bias", 1.0),                // ours, as the next; a constant bias leaves acne
        row("shadow", "max_slope", 16.0),
        row("shadow", "filter", word("none")),
        row("direct", "variant", word("corrected")),
        row("compose", "shadow_color", glm::vec3(0)),    // 4.3; open
        row("ao", "method", word("off")),
    };
}

// Rohleder 2010, Real-time radiosity in image space.
Rows isr() {
    return {
        row("render", "method", word("isr")),
        row("render", "layout", word("isr")),            // fig. 4.1, (22), Listing 4
        row("isr", "variant", word("corrected")),
        row("isr", "mode", word("F2")),                  // appendix D
        row("isr", "resolution", word("quarter")),       // 4.2
        row("isr", "pattern", word("grid")),             // Listing 6
        row("isr", "rings", 4.0),                        // 5.3.1: 80 samples; table 2 has 48
        row("isr", "spacing", 8.0),                      // open: Listing 6 says that the offset is calculated
        row("isr", "ssao_rings", 4.0),                   // Listing 6: the same loops
        row("isr", "ssao_spacing", 2.0),                 // open
        row("isr", "rotations", 1.0),                    // Listing 6
        row("isr", "far_rings", 0.0),                    // 4.4: N is fixed
        row("isr", "bounces", 1.0),                      // 5.2.4
        row("isr", "guard", 0.0),                        // these three are chapter 6's
        row("isr", "layers", 1.0),
        row("isr", "cameras", 0.0),
        row("isr", "position", word("linear")),          // 4.3
        row("isr", "blur", word("gaussian")),            // 4.2; radius and sigma are open
        row("isr", "blur_radius", 4.0),
        row("isr", "blur_sigma", 2.0),
        row("isr", "upsample", word("bilateral")),       // 4.5
        row("isr", "epsilon", 0.001),                    // open
        row("isr", "k_ssao", 0.0),
        row("isr", "k_isr", 1.0),
        row("isr", "ambient", word("none")),
        row("shadow", "mode", word("esm")),              // 4.6, appendix D
        row("shadow", "variant", word("corrected")),
        row("shadow", "esm_c", 90.0),                    // Listing 8
        row("shadow", "esm_blur_radius", 3.0),           // open, as the next
        row("shadow", "esm_blur_sigma", 1.5),
        row("shadow", "filter", word("none")),           // 4.7 names it as a possibility
    };
}

}  // namespace

const std::vector<Preset>& presets() {
    static const std::vector<Preset> all = {
        {"vrsm", "the set-up of VRSM (Bang 2011), with the radiometry of a truth", vrsm()},
        {"vrsm_printed", "the same with its equations as printed",
         joined(vrsm(), {row("rsm", "variant", word("published")),       // (3.2): no 1 / pi; weights by squared distance
                         row("shadow", "variant", word("published")),    // Algorithm 4
                         row("direct", "variant", word("published"))})}, // 4.3: the colour alone, blended by the density
        {"isr", "the set-up of ISR (Rohleder 2010), with the radiometry of a truth", isr()},
        {"isr_printed", "the same with its equations as printed",
         joined(isr(), {row("isr", "variant", word("published")),        // (25), (26), (29)
                        row("isr", "solid_angle", word("printed")),      // the factor 2 pi / N of (25) and (26)
                        row("isr", "ssao_term", word("accessibility")),  // as (29) adds it, occlusion would brighten
                        row("isr", "light_unit", 0.0),                   // open, as the next: by the scene
                        row("isr", "length_unit", 0.0),
                        row("isr", "k_ssao", 0.5),                       // 4.7
                        row("isr", "k_isr", 0.5),
                        row("shadow", "variant", word("published"))})},  // Listing 8
    };
    return all;
}

const Preset& find_preset(const std::string& name, const std::string& place) {
    std::vector<std::string> names;
    for (const Preset& preset : presets()) {
        if (preset.name == name) return preset;
        names.push_back(preset.name);
    }
    throw InputError(fmt::format("{}: unknown preset{}", place, nearest_known(name, names)));
}

}  // namespace plumb::frame
