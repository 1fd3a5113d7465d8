// The rules by which work is left out: each cannot change a bit of the picture, and a test shows it.
//
// A rule is asked about a piece of work: a whole stage, or a part of one (a buffer, a face of a map, a tile). Most are
// asked by plan(), which knows the scene; some by the frame while it runs, which knows what was seen so far.
#pragma once

#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/scene.h"
#include "gi/frame/settings.h"
#include "raster/gbuffer.h"
#include "raster/rsm.h"

namespace plumb::frame {

struct Plan;

struct Box {
    glm::dvec3 low{0}, high{0};  // m
};
Box grown(const Box& box, double by);

// What a plan knows before anything is rendered.
struct PlanFacts {
    const Scene& scene;
    const Settings& settings;
    const Geometry& geometry;
    glm::vec3 low{0}, high{0};            // bounds of what is drawn
    bool empty = false;                   // nothing is drawn
    std::vector<Box> drawn{}, reflecting{};  // of each mesh and material; those whose material reflects
    bool emits = false;                   // some material that is drawn emits
    bool tame = false;                    // every coordinate lies within 1e15 m: squares of distances stay finite
    double slack = 0;                     // m: how far off its surface a pixel's stored position may lie
    std::vector<bool> shines{};           // of each light: no rule of its own leaves it out
};

// What a run knows when it comes to a stage.
struct RunFacts {
    const raster::GBuffer& gbuffer;
    std::span<const raster::Rsm> maps;  // of the stage's light
    const raster::Covered& covered;     // of the pixels that the stage writes
};

struct Work {
    std::string stage;  // a kind of work: "camera" (what it sees), "rsm", "shadow", "gather", "filter", "direct", "compose",
                        // "truth.direct", "truth.indirect", "truth.ao", "truth.reflection", "ao", "ao light" (from its maps), "reflect",
                        // "reflect light" (in its maps), "reflect shadow", "reflect direct" (on what was met behind the picture); of method isr "isr" (radiosity and gathers), "isr access",
                        // "isr lit" (what both go through) and "isr view" (what other cameras see); "probes" (the lightmap
                         // and what reads it), "relief" (normal maps and highlights), "probes shadow" (what dynamic meshes hide)
    std::string part;   // empty: all of it; else "albedo", "emission", "light" of a map, "face", "tile", "mesh": spatial receivers near it
    int light = -1;     // index into Scene::lights; -1: of none
    int index = -1;     // of the face, of the tile, row by row, or of the mesh
};

struct Rule {
    std::string name;                 // "light-off": stable, in plan and run.json
    std::vector<std::string> stages;  // that it may leave out, as Work names them
    std::string part;                 // as Work has it
    std::string reason;               // "the light is off"
    // One of them: of what the plan knows, or of what only the run sees.
    bool (*holds)(const PlanFacts& known, const Work& work) = nullptr;
    bool (*seen)(const RunFacts& seen, const Work& work) = nullptr;

    bool speaks_of(const Work& work) const;
};

// In the order in which they are asked: the first that holds leaves the work out.
const std::vector<Rule>& rules();

// The first rule that holds, or null.
const Rule* left_out_by(const std::vector<Rule>& rules, const PlanFacts& known, const Work& work);
const Rule* left_out_by(const std::vector<Rule>& rules, const RunFacts& seen, const Work& work);

// As plan() of frame.h, by other rules, and refusing nothing in advance: a test breaks a rule and must see the picture
// change, and stability sees what each stage refuses by itself.
Plan plan(const Scene& scene, const Settings& settings, const std::vector<Rule>& rules);

// Everything that rules ask. The scene, the settings and the geometry must outlive it.
PlanFacts known_of(const Scene& scene, const Settings& settings, const Geometry& geometry);

// Whether a spot, a point or a directional light may send light to a point of the box, or a map of a spot show it.
bool may_light(const Light& light, const Box& box);
// Whether the camera may see a point of the box.
bool may_see(const Scene& scene, const Box& box);

}  // namespace plumb::frame
