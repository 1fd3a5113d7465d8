// The frame: which stages a scene needs, their order, and their buffers.
//
//     Scene + Settings --plan--> Plan --execute--> Frame
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/scene.h"
#include "core/stage.h"
#include "core/tap.h"
#include "gi/frame/rules.h"
#include "gi/frame/settings.h"
#include "gi/frame/truth.h"
#include "gi/graph/graph.h"
#include "gi/probes/lightmap_uv.h"
#include "gi/probes/run_data.h"
#include "gi/probes/relief.h"
#include "gi/probes/run_loop.h"
#include "gi/probes/shadow_spheres.h"
#include "gi/probes/volume.h"
#include "gi/radiosity/host_stages.h"
#include "gi/radiosity/lookup.h"
#include "gi/screen/last_frame.h"
#include "gi/zbuffer/zbuffer.h"
#include "raster/gbuffer.h"
#include "raster/rsm.h"

namespace plumb::frame {

using graph::LeftOut;
// A stage as the plan has it. view: index into Frame::views of what it draws or reads beside the frame; 0: itself. layer: of
// a path traced stage, which layer it makes (truth.h).
using PlannedStage = graph::NodePlan;

// What is drawn of a light's maps.
struct PlannedMaps {
    raster::RsmWants wants;
    unsigned faces = 0x3f;  // bit m: map m is drawn
};

struct Plan {
    std::vector<PlannedStage> stages;  // in the order in which they run
    raster::GBufferWants gbuffer;      // the buffers that are computed; the others are 0
    std::vector<PlannedMaps> maps;     // [lights]
    std::vector<int> unseen;           // dynamic meshes, ascending, for which no spatial receiver is computed
    std::vector<Rule> run_rules;       // those that the run has to ask; none without pruning
};

// A pure function of what it is given. Leaves out what cannot change the picture, by rules() of rules.h. Throws
// InputError for what this version cannot render, and for what no frame can serve (refusals.h).
Plan plan(const Scene& scene, const Settings& settings);

using StageRun = graph::NodeRun;

// What a method lights beside the frame (gi/frame/isr.h): a guard band around it, layers behind it, other cameras; what probes'
// rays meet.
struct SourceView {
    std::string name;          // "guard", "layer 2", "camera 1"
    Camera camera;
    glm::ivec2 size{0};        // pixels
    raster::GBuffer gbuffer;
    Buffer<float> visibility;  // [lights][height][width]
    Image4 direct;             // irradiance, W/m2
    Image4 surface, radiosity; // as isr.downsample makes them
};

// What method isr makes (gi/isr), of a quarter of the pixels; empty where its stages do not run.
struct IsrBuffers {
    Image4 surface, radiosity, reflectance;
    std::vector<Image4> unseen;       // of each pass of isr.unseen, in their order
    std::vector<Image4> gathered;     // of each pass of isr.gather and isr.gather_camera
    std::vector<Image4> radiosities;  // of each pass of isr.bounce
    Image4 lit;                       // ISR_4: xyz irradiance, w accessibility
    Image4 blurred_across, blurred;
};

// Of normal maps and highlights (gi/frame/nodes_relief.cpp); empty where nothing asks for them.
struct ReliefBuffers {
    Buffer<float> visibility;                    // [lights][height][width]: 0 where what moves has no direct light of a static lamp
    raster::GBuffer plain;                       // drawn without normal maps
    Image4 fixed_normal, fixed_plain;            // of static surfaces; w 0 of others
    probes::VolumeLight fixed, fixed_unmapped;   // of them, along either
    probes::VolumeLight asked;                   // of all surfaces, along the normals of the frame
    Image4 specular;                             // k_s, exponent
    probes::ReliefLight made;
    Image4 sent;                                 // emission and highlights, W/m2
    // Figure 5.20, with a reflectance of 1.
    probes::VolumeLight unmapped;                // of what moves
    Image4 white, plain_direct, plain_indirect;
    struct Layer {
        std::string name;
        Image4 radiance, display;                // W/(m2 sr); under the picture's tone curve
    };
    std::array<Layer, 3> layers = {Layer{"diffuse", {}, {}}, Layer{"normals", {}, {}}, Layer{"specular", {}, {}}};
};

// What method probes makes (gi/probes); empty where its stages do not run. What relight rays meet are pixels of a view of its own,
// Frame::views[1]: columns rays, rows probes.
struct ProbeBuffers {
    probes::RunData data;                    // of the bake, as the stages read it
    probes::ChartedTriangles charted;
    Image4 surface, emitted, place;          // of relight hits (gi/probes/hit_surfaces.h)
    Buffer<float> harmonics, weights;        // as probes.lambda reads them
    std::vector<std::int32_t> probe_level, cluster_level, basis_level;
    probes::Lod lod;                         // of the bake
    probes::LodBoxes boxes;                  // of what has a level of detail; empty without
    Image4 placed;                           // `place` with the level that a hit is looked up in; empty without levels
    Image4 before;                           // the lightmap that relight rays look up: of the round, or the frame, before
    Image4 radiance, lambda, basis, irradiance, lightmap;
    probes::TilesToWrite tiles;              // of the lightmap
    Image4 uv;                               // of the frame's pixels
    // Of dynamic meshes; empty where there are none, or no spatial receivers.
    probes::ClusterData spatial;
    std::vector<probes::Box> spatial_readers;    // what reads it
    std::vector<std::int32_t> spatial_active;    // [places]: 0 near what moves, else -1
    std::vector<std::int32_t> spatial_levels;    // of its clusters: 0 with a place near what moves, else none
    probes::AirLevels air;                       // its levels of detail; empty without
    std::vector<std::int32_t> air_active;        // [places]: the coarsest level where they are computed, else -1
    Image4 spatial_basis, spatial_irradiance;
    Buffer<glm::vec4> bounced, grid;             // [place][direction], W/m2: without static lamps, and with them
    Buffer<glm::vec4> static_light;              // the same of static lamps alone; empty without any
    probes::VolumeLight volume;                  // of pixels without a place on the lightmap
    Image4 looked_up;                            // what the lightmap brings, before the two are joined
    // Of indirect shadows; empty where they are off.
    std::vector<Buffer<glm::vec4>> fitted;       // of each group of dynamic meshes, in its own space
    probes::ShadowSpheres shadow_spheres;
    Image4 unshaded;                             // indirect light without them, W/m2
    Image4 joined;                               // after that
    ReliefBuffers relief;
    probes::Convergence converged;           // of the rounds; loop = converged
    // loop = pipelined: what the frame reads of the one before, and what it leaves for the next; empty: there is none. Both are
    // there after a frame, so that what its stages read can be looked at.
    struct Pipeline {
        Image4 direct, lambda, basis, lightmap;
        Image4 lambda_2, lambda_3;  // of two and three frames before the next: spatial receivers have one step where the lightmap has three
    };
    Pipeline last, next;
};

// What method radiosity makes (gi/radiosity); empty where its stages do not run. Lists have a number an element, W/m2.
struct RadiosityBuffers {
    radiosity::Elements elements;
    radiosity::TriangleElements triangles;
    radiosity::FormFactors factors;
    int rows_found = 0;             // blocks of them that the store had
    Buffer<glm::vec4> lamps, sky;   // irradiance; sky: by small emitters, too
    Buffer<glm::vec4> emitters;     // of sky, that by small emitters
    Buffer<glm::vec4> radiosity;
    Buffer<glm::vec4> irradiance;   // but by lamps
    radiosity::Solved solved;
};

// What method zbuffer makes (gi/zbuffer) beside `direct`; empty where its stages do not run.
struct ZbufferBuffers {
    zbuffer::VertexTable table;
    zbuffer::VertexLight vertex_light;
    Image4 sent;            // emission and pi times highlights, W/m2
    Image4 vertex_normals;  // the picture with vertices' normals over it
};

// Of ambient occlusion (gi/screen); empty where its stages do not run.
struct AoBuffers {
    std::vector<Image4> views;  // after the camera, and after each light's map: what was summed
    Image4 open;                // xyz open share; w 1 on a surface
    Image4 lit;                 // indirect and ambient irradiance, by the open share, W/m2
};

// Of reflections (gi/screen); empty where its stages do not run.
struct ReflectBuffers {
    Image4 mirror;                // xyz reflectance of the perfect mirror that a pixel sees; 0: none
    Image4 lobe;                  // of Phong's lobe that it sees: xyz reflectance, w exponent; 0: none
    Image4 rays;                  // of lobes: a sheet (gi/screen/sheet.h) of pictures of xyz direction and w weight, a ray each
    std::vector<Image4> nearest;  // of each view that is marched by cells: the least depths of its blocks
    std::vector<Image4> hits;     // after the camera, each layer and each light's map: texel, distance, view
    std::vector<std::vector<raster::GBuffer>> seen;  // [lights][maps]: what else is known of a map's texels
    Image4 composed;              // the picture without reflections, W/(m2 sr)
    Image4 reflection;            // W/(m2 sr); w 1 where something was met
};

struct Frame {
    raster::GBuffer gbuffer;
    // [lights][1, or 6 faces of a point light]; size 0 where none was needed, or nothing can be seen.
    std::vector<std::vector<raster::Rsm>> rsms;
    // Of the blurred maps: w linear depth, m; [lights][maps], empty images where nothing was drawn. Across: of its first pass.
    std::vector<std::vector<Image4>> maps_blurred_across, maps_blurred;
    Buffer<float> visibility;  // [lights][height][width]
    // The same after shadow.filter, and after its first pass; empty where it does not run.
    Buffer<float> visibility_filtered, visibility_across;
    Image4 direct, indirect;   // irradiance, W/m2; of method isr indirect's w: accessibility
    // Of filters of the indirect light alone (filters.h); empty where they do not run.
    Image4 half_position, half_normal;
    Image4 gathered;           // the sum of all gathers, W/m2, at their own size; w: linear depth, m (VRSM fig. 4.4)
    Image4 reused, reused_age; // of screen.reuse: the mean of frames, W/m2, and of how many
    Image4 upsampled, blurred_across;  // what further filters read
    // What screen.reuse reads of the frame before, and what it leaves for the next, both there after a frame.
    screen::LastFrame last_light, next_light;
    std::uint32_t light_frames = 0;    // that were gathered, with this one
    IsrBuffers isr;
    ProbeBuffers probes;
    RadiosityBuffers radiosity;
    ZbufferBuffers zbuffer;
    AoBuffers ao;
    ReflectBuffers reflect;
    std::vector<SourceView> views;  // of method isr; [0] stands for the frame itself and is empty
    Image4 indirect_error;     // standard error of `indirect`, by channel, W/m2; empty where no rsm.all_rays ran
    Image4 radiance;           // outgoing, W/(m2 sr)
    Image4 display;            // sRGB-encoded, 0..1
    std::vector<Traced> traced;  // the path traced layers, in the plan's order
    Image4 truth_display;      // sRGB-encoded, 0..1: the truth under the picture's tone curve
    std::vector<StageRun> stages;
};

// What the frame's direct light reads of its shadows: filtered where they are.
inline const Buffer<float>& shadows_of(const Frame& frame) {
    return frame.visibility_filtered.empty() ? frame.visibility : frame.visibility_filtered;
}

using graph::Progress;

// What was made before and is kept in files; null: nothing is.
struct Stores {
    reference::Store* traced = nullptr;  // path traced layers
    graph::Store* rows = nullptr;        // radiosity's rows; must outlive the frame where they do not fit into memory
    Stores(reference::Store* t = nullptr, graph::Store* r = nullptr) : traced(t), rows(r) {}
};

// The picture does not depend on the options. What the stores keep is taken from there, and kept there where it is made.
// kept.h has one that also keeps what every other stage made, for the frame after.
Frame execute(const Scene& scene, const Settings& settings, const Plan& plan, const RunOptions& options,
              const Progress& progress = {}, const Stores& stores = {});

// The plan with what only the run could leave out.
Plan plan_after_run(const Plan& plan, const Frame& frame);

// The traced layer of that name, or null.
const Traced* find_traced(const Frame& frame, const std::string& layer);

// One stage's values at one pixel (for stage "rsm": a texel of the light's map; the six maps of a point light lie side
// by side, so that x runs to 6 rsm_size).
struct Explanation {
    std::string stage;  // label
    glm::ivec2 pixel{0};
    std::vector<TapValue> values;
};

// Every named value of `stage` at `pixel`, from a frame that was executed. light: index into Scene::lights, or -1 for
// the first that the plan needs. An empty stage: all stages of the frame at that pixel, in order. Throws InputError for
// an unknown stage (naming the nearest), a stage that the plan leaves out, or a pixel outside the image.
std::vector<Explanation> explain(const Scene& scene, const Settings& settings, const Plan& plan, const Frame& frame,
                                 const std::string& stage, int light, glm::ivec2 pixel);

// Every stage that exists: the rows of `plumb stages`. First those of a frame, in its order, then passes that no frame
// runs by itself.
std::vector<StageInfo> all_stages();
bool in_a_frame(const std::string& stage);

}  // namespace plumb::frame
