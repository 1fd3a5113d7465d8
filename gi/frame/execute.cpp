#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "core/content_hasher.h"
#include "core/fp_environment.h"
#include "gi/direct/log_blur.h"
#include "gi/frame/at_run.h"
#include "gi/frame/filters.h"
#include "gi/frame/isr.h"
#include "gi/frame/kept.h"
#include "gi/frame/run_stage.h"

namespace plumb::frame {

namespace {

// Where in the frame a stage leaves what it makes.
std::string place_of(const Settings& settings, const PlannedStage& stage) {
    if (is_gather(stage.name)) return fmt::format("gather {}", stage.light);
    if (is_filter(stage.name)) return filter_place(settings, stage);
    if (is_isr(stage.name)) return isr_place(stage);
    if (stage.name == "shadow.blur") return fmt::format("shadow.blur {} {}", stage.light, stage.form);
    if (stage.name == "compose") return "radiance";
    if (stage.name == "reference") return stage.layer;
    if (stage.view > 0) return fmt::format("{} {} of view {}", stage.name, stage.light, stage.view);
    return stage.light < 0 ? stage.name : fmt::format("{} {}", stage.name, stage.light);
}

// Runs a plan stage by stage, and leaves alone what has the key it wants.
class Execution {
  public:
    // keys: empty where nothing is kept. The arguments must outlive it.
    Execution(Context& context, const std::vector<std::uint64_t>& keys, const RunOptions& given,
              const Progress& progress)
        : c_(context), f_(context.frame), keys_(keys), given_(given), progress_(progress),
          before_(std::exchange(context.memory.made, {})), traced_(std::exchange(f_.traced, {})) {}

    void run() {
        make_room();
        begin_sum();
        f_.stages.clear();
        for (std::size_t i = 0; i < c_.plan.stages.size(); ++i) f_.stages.push_back(stage(i));
        forget();
    }

  private:
    std::map<std::string, Made>& made() { return c_.memory.made; }

    // What was made before in a place, if it was made from the same.
    const Made* holds(const std::string& place, std::uint64_t key) const {
        const auto at = before_.find(place);
        return at != before_.end() && at->second.key == key ? &at->second : nullptr;
    }
    const Made* kept(std::size_t i) const {
        return keys_.empty() ? nullptr : holds(place_of(c_.settings, c_.plan.stages[i]), keys_[i]);
    }

    void make_room() {
        const std::size_t lights = c_.lights.size();
        f_.rsms.resize(lights), f_.maps_blurred_across.resize(lights), f_.maps_blurred.resize(lights);
        begin_views(c_.scene, c_.settings, f_);
        c_.memory.irradiance.resize(lights), c_.memory.irradiance_error.resize(lights);
        if (f_.visibility.size() == lights * c_.pixels) return;
        f_.visibility.resize(lights * c_.pixels);
        std::erase_if(before_, [](const auto& place) { return place.first.rfind("shadow ", 0) == 0; });
    }

    // The sum of the gathers stays where every term does.
    void begin_sum() {
        if (gathers_isr(c_.settings)) {
            f_.indirect_error = {};  // isr.upsample fills the place of the sum
            return;
        }
        ContentHasher h;
        h.add(c_.size);
        c_.sum_is_kept = !keys_.empty();
        for (std::size_t i = 0; i < keys_.size(); ++i) {
            if (!c_.plan.stages[i].needed || !is_gather(c_.plan.stages[i].name)) continue;
            h.add(keys_[i]);
            c_.sum_is_kept = c_.sum_is_kept && kept(i);
        }
        const bool filtered = filters_indirect(c_.settings);
        const std::string place = filtered ? "gathered" : "indirect";
        c_.sum_is_kept = c_.sum_is_kept && holds(place, h.hash);
        made()[place].key = h.hash;
        if (c_.sum_is_kept) return;
        const glm::ivec2 size = gather_size(c_.settings, c_.size);
        (filtered ? f_.gathered : f_.indirect) = Image4(size.x, size.y);
        if (!filtered || f_.indirect.empty()) f_.indirect = Image4(c_.size.x, c_.size.y);
        f_.indirect_error = {};
    }

    StageRun stage(std::size_t i) {
        const PlannedStage& stage = c_.plan.stages[i];
        StageRun run;
        run.label = stage.label, run.needed = stage.needed, run.reason = stage.reason;
        run.rule = stage.rule, run.saved_ms = stage.saved_ms, run.parts = stage.parts;
        const auto start = std::chrono::steady_clock::now();
        const Made* before = kept(i);
        if (before)
            reuse(i, *before, run);
        else
            make(stage, run);
        if (stage.layer == "truth" && stage.needed) show_truth(i);
        if (stage.needed)
            run.ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
        // What the run left out may depend on more than its key.
        if (!keys_.empty() && run.needed == stage.needed) made()[place_of(c_.settings, stage)] = {keys_[i], before ? before->run : run};
        if (!keys_.empty() && stage.layer == "color") made()["radiance"].key = keys_[i];
        return run;
    }

    void make(const PlannedStage& stage, StageRun& run) {
        if (!stage.needed) return kind_of(stage).leave_out(c_, stage, run);
        c_.options = given_;
        if (progress_) {
            progress_(stage.label, 0);
            c_.options.progress = [&](double done) { progress_(stage.label, done); };
        }
        if (left_out_at_run(c_.plan, f_, stage, run)) return kind_of(stage).leave_out(c_, stage, run);
        kind_of(stage).run(c_, stage, run);
        run.isa = last_dispatched_isa();
    }

    void reuse(std::size_t i, const Made& before, StageRun& run) {
        const PlannedStage& stage = c_.plan.stages[i];
        if (stage.name == "reference") {
            for (Traced& traced : traced_)
                if (traced.layer == stage.layer) f_.traced.push_back(std::move(traced));
            // A stage between may have written there.
            if (stage.layer == "color" && (made().contains("radiance") || !holds("radiance", keys_[i])))
                f_.radiance = f_.traced.back().estimate.mean;
        }
        if (!stage.needed) return;
        const std::size_t l = std::size_t(stage.light);
        if (is_gather(stage.name)) add_gather(c_, c_.memory.irradiance[l], c_.memory.irradiance_error[l]);
        run.kept = true;
        run.reason = "kept: nothing that it reads has changed";
        run.saved_ms = before.run.ms, run.bytes = before.run.bytes, run.isa = before.run.isa;
    }

    // The truth under the picture's tone curve.
    void show_truth(std::size_t i) {
        ContentHasher h;
        h.add(keys_.empty() ? 0 : keys_[i], tonemap_key(c_.settings));
        if (keys_.empty() || !holds("truth_display", h.hash))
            compose::run(c_.settings.tonemap, compose::TonemapInputs{&f_.traced.back().estimate.mean}, given_,
                         f_.truth_display);
        made()["truth_display"].key = h.hash;
    }

    // What no stage of this plan makes is not there.
    void forget() {
        if (!made().contains("truth_display")) f_.truth_display = {};
        const std::vector<FilterStage> before = filters_before_gathers(c_.settings), after = filters_after_gathers(c_.settings);
        if (!gathers_isr(c_.settings)) f_.isr = {};
        if (!direct::blurs_maps(c_.settings.shadow))
            for (std::size_t l = 0; l < c_.lights.size(); ++l) f_.maps_blurred_across[l] = f_.maps_blurred[l] = {};
        if (before.empty()) f_.half_position = f_.half_normal = {};
        if (after.empty()) f_.gathered = {};
        if (before.empty() || after.size() < 2) f_.upsampled = {};
        if (c_.settings.indirect.blur != filter::Blur::separable || after.empty()) f_.blurred_across = {};
        for (std::size_t l = 0; l < c_.lights.size(); ++l)
            if (!made().contains(fmt::format("gather {}", l))) c_.memory.irradiance[l] = c_.memory.irradiance_error[l] = {};
        if (keys_.empty()) made().clear();
    }

    Context& c_;
    Frame& f_;
    const std::vector<std::uint64_t>& keys_;
    const RunOptions& given_;
    const Progress& progress_;
    std::map<std::string, Made> before_;
    std::vector<Traced> traced_;  // of the frame before
};

// keys: of scene and stages, or null and empty.
void execute_in(KeptMemory& memory, const Scene& scene, const Settings& settings, const Plan& plan,
                const RunOptions& given, const Progress& progress, reference::Store* store, const SceneKeys* scene_keys,
                const std::vector<std::uint64_t>& keys) {
    World& world = memory.world;
    world.update(scene, settings, scene_keys);
    Context c{scene,        settings, plan,
              given,        memory,   world,
              memory.frame, scene.frame_size, std::size_t(scene.frame_size.x) * std::size_t(scene.frame_size.y),
              {},           Tracer(scene, settings, world.geometry, store, &world.paths)};
    for (const Light& light : scene.lights) c.lights.push_back(shining(light));
    c.keeps = !keys.empty();
    Execution(c, keys, given, progress).run();
}

}  // namespace

Frame execute(const Scene& scene, const Settings& settings, const Plan& plan, const RunOptions& options,
              const Progress& progress, reference::Store* store) {
    FpEnvironment environment;
    KeptMemory memory;
    execute_in(memory, scene, settings, plan, options, progress, store, nullptr, {});
    return std::move(memory.frame);
}

const Frame& execute(const Scene& scene, const Settings& settings, const Plan& plan, const RunOptions& options,
                     KeptStages& kept, const Progress& progress, reference::Store* store) {
    FpEnvironment environment;
    KeptMemory& memory = kept.memory();
    try {
        const SceneKeys of_scene = scene_keys(scene);
        const std::vector<std::uint64_t> keys =
            kept.other_keys() ? kept.other_keys()(scene, settings, plan, options.isa)
                              : stage_keys(of_scene, scene, settings, plan, options.isa);
        execute_in(memory, scene, settings, plan, options, progress, store, &of_scene, keys);
    } catch (...) {
        memory = KeptMemory();
        throw;
    }
    return memory.frame;
}

}  // namespace plumb::frame
