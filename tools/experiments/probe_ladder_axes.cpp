// plumb experiment probe-ladder: the rungs, one setting after the other.
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "core/error.h"
#include "core/host_math.h"
#include "core/sequences.h"
#include "gi/probes/sky_probe.h"
#include "tools/experiments/probe_ladder_rung.h"

namespace plumb::cli {

namespace {

using Params = probes::BakeParams;

constexpr int turned_sets = 3;  // other sets of directions
constexpr int most_turned_rays = 1024;

// A rotation of the sphere, another one for each k: about an axis anywhere, by an angle that is not small.
glm::dmat3 rotation(int k) {
    const glm::dvec3 axis = sample_sphere(halton(std::uint64_t(k) + 1));
    const double angle = host::pi * (0.3 + 0.5 * van_der_corput(std::uint64_t(k) + 1, 5)), c = host::cos(angle),
                 s = host::sin(angle);
    glm::dmat3 r;
    for (int column = 0; column < 3; ++column) {
        glm::dvec3 e(0);
        e[column] = 1;
        r[column] = c * e + s * glm::cross(axis, e) + (1 - c) * glm::dot(axis, e) * axis;
    }
    return r;
}

class Climber {
  public:
    Climber(const Scene& scene, const Params& params, const LadderRequest& request, const RunOptions& options,
            const std::function<void(const std::string&)>& progress)
        : params_(params), options_(options), progress_(progress), measure_(scene, params, request, options, progress) {
        out_.scene = scene.name, out_.request = request, out_.params = params;
    }

    Ladder run() {
        const probes::Bake& b = base().bake;
        out_.receivers = b.receivers.count(), out_.probes = probes::standing_probes(b.placement.probes), out_.checked = checked().count();
        out_.before_sky = checked().before_sky;
        add(measure_.rung_of(base(), "default", "", 0, ""));
        out_.rungs.front().is_default = true;
        out_.mean = checked().mean(), out_.uncertainty = checked().relative_uncertainty();
        const LadderPlaced& placed = measure_.placed_of(b);
        const LadderTransport& transport = measure_.transport_of(b);
        const std::vector<double> half = lambda_in_double(placed.light, measure_.weights(placed.light.rays() / 2), options_);
        out_.many_uncertainty =
            local_rms(checked(), minus(uncut(transport, placed.many, params_.degree), uncut(transport, half, params_.degree)));
        if (asked("probes")) climb_probes();
        if (asked("overlaps")) climb_overlaps();
        if (asked("degree")) climb_degree();
        if (asked("window")) climb_windows();
        if (asked("relight")) climb_relight();
        if (asked("rays")) climb_rays();
        if (asked("clusters")) climb_clusters();
        if (asked("receivers")) climb_receivers();
        if (asked("placement")) climb_placement();
        if (asked("products")) climb_products();
        return std::move(out_);
    }

  private:
    const LadderBaked& base() const { return measure_.base(); }
    const CheckedReceivers& checked() const { return measure_.checked(); }
    bool asked(const std::string& axis) const { return out_.request.axes.empty() || out_.request.axes.count(axis); }
    void add(LadderRung rung) { out_.rungs.push_back(std::move(rung)); }

    // Bakes and adds the rung; what cannot be baked is left out with the reason.
    std::optional<LadderBaked> climb(const std::string& axis, const std::string& line, double value, const Params& params,
                                     const std::string& settings) {
        progress_(fmt::format("{}: {}", axis, settings));
        try {
            LadderBaked made = measure_.bake(params);
            add(measure_.rung_of(made, axis, line, value, settings));
            return made;
        } catch (const InputError& e) {
            out_.left_out.push_back(fmt::format("{}: {}", settings, e.what()));
            return {};
        }
    }

    // The default as a rung of an axis.
    void add_default(const std::string& axis, const std::string& line, double value) {
        LadderRung r = out_.rungs.front();
        r.axis = axis, r.line = line, r.value = value;
        add(r);
    }

    // Calls `at` for each value that is not the default's, which stands among them.
    template <class At>
    void climb_values(const std::string& axis, const std::string& line, std::vector<int> values, int own, At at) {
        if (std::find(values.begin(), values.end(), own) == values.end()) values.push_back(own);
        std::sort(values.begin(), values.end());
        for (const int v : values)
            if (v == own)
                add_default(axis, line, own);
            else
                at(v);
    }

    // ---- Axes ----

    void climb_probes() {
        std::vector<int> counts;
        for (int n = 1; n <= out_.request.most_probes; n *= 2) counts.push_back(n);
        climb_values("probes", "probes", counts, out_.probes, [&](int n) {
            Params p = params_;
            p.placement.count = n;
            climb("probes", "probes", n, p, fmt::format("probes.count={}", n));
        });
    }

    void climb_overlaps() {
        const std::vector<int> values = {1, 2, 3, 5, 7, 10, 13, 16};
        climb_values("overlaps", fmt::format("{} probes", out_.probes), values, params_.placement.overlaps, [&](int n) {
            Params p = params_;
            p.placement.overlaps = n;
            climb("overlaps", fmt::format("{} probes", out_.probes), n, p, fmt::format("probes.overlaps={}", n));
        });
        const int more = std::min(8 * out_.probes, out_.request.most_probes);
        if (more <= out_.probes) return;
        for (const int n : values) {
            Params p = params_;
            p.placement.overlaps = n, p.placement.count = more;
            climb("overlaps", fmt::format("{} probes", more), n, p, fmt::format("probes.count={} probes.overlaps={}", more, n));
        }
    }

    void climb_degree() {
        climb_values("degree", "degree", {0, 1, 2, 3, 4, 5, 6, 7}, params_.degree, [&](int n) {
            Params p = params_;
            p.degree = n;
            climb("degree", "degree", n, p, fmt::format("probes.degree={}", n));
        });
    }

    // Windows that keep harmonics from overshooting (Sloan 2008, "Stupid Spherical Harmonics Tricks"); the run time has none.
    void climb_windows() {
        using Window = double (*)(double);
        const std::vector<std::pair<const char*, Window>> windows = {
            {"none", [](double) { return 1.0; }},
            {"Lanczos", [](double t) { return t == 0 ? 1.0 : host::sin(host::pi * t) / (host::pi * t); }},
            {"Hann", [](double t) { return 0.5 + 0.5 * host::cos(host::pi * t); }}};
        for (const auto& [name, window] : windows)
            for (int degree = 0; degree <= 7; ++degree) {
                std::vector<double> factors;
                for (int l = 0; l <= degree; ++l) factors.push_back(window(double(l) / (degree + 1)));
                add(measure_.windowed_rung(factors, name));
            }
    }

    void climb_relight() {
        std::vector<ProbeLight> turned;
        for (int k = 0; k < turned_sets; ++k) {
            Buffer<glm::vec4> directions;
            const glm::dmat3 r = rotation(k);
            for (int i = 0; i < std::max(2048, params_.relight_rays); ++i)
                directions.emplace_back(glm::vec3(r * glm::dvec3(measure_.directions()[std::size_t(i)])), 0);
            turned.push_back(
                probe_light(measure_.world(), measure_.radiance(), base().bake.placement.probes, directions, base().bake.transport.escape, options_));
        }
        const LadderTransport& transport = measure_.transport_of(base().bake);
        const std::vector<double> by_many = uncut(transport, measure_.placed_of(base().bake).many, params_.degree);
        const auto add_lines = [&](const LadderBaked& baked, const std::string& settings) {
            const int n = baked.bake.params.relight_rays;
            for (const bool quadrature : {true, false}) {
                LadderRung r =
                    measure_.rung_of(baked, "relight", quadrature ? "quadrature weights" : "4 pi / N", n, settings, quadrature);
                for (const ProbeLight& light : turned) {
                    const Buffer<float> w = quadrature ? probes::relight_weights(light.directions, n) : equal_weights(n);
                    r.others.push_back(local_rms(
                        checked(), minus(uncut(transport, lambda_in_double(light, w, options_), params_.degree), by_many)));
                }
                r.is_default = quadrature && n == params_.relight_rays;
                add(r);
            }
        };
        std::vector<int> values = {64, 128, 256, 512, 1024, 2048};
        if (std::find(values.begin(), values.end(), params_.relight_rays) == values.end())
            values.push_back(params_.relight_rays);
        std::sort(values.begin(), values.end());
        for (const int n : values) {
            const std::string settings = fmt::format("probes.relight_rays={}", n);
            progress_("relight: " + settings);
            Params p = params_;
            p.relight_rays = n;
            add_lines(n == params_.relight_rays ? base() : measure_.bake(p), n == params_.relight_rays ? "" : settings);
        }
    }

    void climb_rays() {
        climb_values("rays", "rays", {64, 128, 256, 512, 1024, 2048, 4096}, params_.receiver_rays, [&](int n) {
            Params p = params_;
            p.receiver_rays = n;
            climb("rays", "rays", n, p, fmt::format("probes.receiver_rays={}", n));
        });
        std::vector<int> prefixes;
        for (const LadderRung& r : out_.rungs)
            if (r.axis == "rays" && r.value <= most_turned_rays) prefixes.push_back(int(r.value));
        if (prefixes.empty()) return;
        for (int k = 0; k < turned_sets; ++k) {
            progress_("rays: turned about the normals");
            const auto by =
                irradiance_by(measure_.world(), measure_.radiance(), checked().receivers, checked().directions, prefixes,
                              params_.distribution, 2 * host::pi * van_der_corput(std::uint64_t(k) + 1, 5), options_);
            for (std::size_t i = 0; i < prefixes.size(); ++i)
                for (LadderRung& r : out_.rungs)
                    if (r.axis == "rays" && int(r.value) == prefixes[i])
                        r.others.push_back(local_rms(checked(), minus(by[i], checked().truth)));
        }
    }

    void climb_clusters() {
        const float own = params_.threshold, loose = std::min(1.0f, 6 * own);
        struct Way {
            std::string line, settings;
            float threshold;
            bool by_size;
        };
        const std::vector<Way> ways = {
            {fmt::format("threshold {:g}", own), "", own, params_.by_size_only},
            {fmt::format("threshold {:g}", loose), fmt::format(" probes.threshold={:g}", loose), loose, false},
            {"by size alone", " probes.by_size_only=true", own, true}};
        for (const Way& way : ways) {
            std::vector<int> values = {4, 8, 16, 24, 32, 48, 64};
            if (std::find(values.begin(), values.end(), params_.singular_values) == values.end())
                values.push_back(params_.singular_values);
            std::sort(values.begin(), values.end());
            for (const int n : values) {
                Params p = params_;
                p.singular_values = n, p.threshold = way.threshold, p.by_size_only = way.by_size;
                if (n == params_.singular_values && way.settings.empty()) {
                    add_default("clusters", way.line, n);
                    continue;
                }
                const std::string settings = fmt::format("probes.singular_values={}{}", n, way.settings);
                progress_("clusters: " + settings);
                add(measure_.rung_of(measure_.cut_again(base(), p), "clusters", way.line, n, settings));
            }
        }
    }

    static Params scaled(Params p, double factor) {
        if (p.lightmap_size > 0)
            p.lightmap_size = int(p.lightmap_size * factor + 0.5);
        else
            p.receivers_per_m2 = float(double(p.receivers_per_m2) * factor * factor);
        return p;
    }

    // Lightmaps of other sizes, looked up where the finest has its receivers.
    void climb_receivers() {
        CheckedReceivers fine;
        std::vector<double> own;
        std::vector<LadderRung> rungs;
        for (const double factor : {2.0, 1.0, 0.5, 0.25, 0.125}) {
            const Params p = scaled(params_, factor);
            const std::string settings = p.lightmap_size > 0 ? fmt::format("probes.lightmap_size={}", p.lightmap_size)
                                                             : fmt::format("probes.receivers_per_m2={:g}", p.receivers_per_m2);
            progress_("receivers: " + settings);
            try {
                const LadderBaked made = factor == 1 ? base() : measure_.bake(p);
                const std::vector<float> irradiance = measure_.shown(made.bake);
                if (fine.count() == 0) {
                    fine = check_receivers(measure_.world(), measure_.radiance(), made.bake.receivers, out_.request.check, 1,
                                           params_.distribution, options_);
                    for (const int i : fine.index) own.push_back(double(irradiance[std::size_t(i)]));
                }
                LadderRung r;
                r.axis = "receivers", r.line = "receivers", r.value = made.bake.receivers.count();
                r.settings = factor == 1 ? "" : settings, r.is_default = factor == 1;
                measure_.add_costs(made, r);
                LadderSteps steps;
                steps.value = looked_up(measure_.world(), made.bake, irradiance, fine.receivers);
                for (std::vector<double>& added : steps.added) added.assign(steps.value.size(), 0);
                r.errors = errors_of(fine, steps);
                r.lookup = local_rms(fine, minus(steps.value, own));
                rungs.push_back(r);
            } catch (const InputError& e) {
                out_.left_out.push_back(fmt::format("{}: {}", settings, e.what()));
            }
        }
        std::stable_sort(rungs.begin(), rungs.end(),
                         [](const LadderRung& a, const LadderRung& b) { return a.value < b.value; });
        for (LadderRung& r : rungs) add(std::move(r));
    }

    // As many probes as on the axis of probes, but chosen, of a dense placement, by what they see. The transport is not cut.
    void climb_placement() {
        progress_("placement");
        Params p = params_;
        p.placement.count = out_.request.most_probes;
        Buffer<glm::vec4> places;
        try {
            places = probes::place_probes(measure_.world().geometry, *measure_.world().query, p.placement, options_).probes;
        } catch (const InputError& e) {
            out_.left_out.push_back(fmt::format("placement of {} probes: {}", out_.request.most_probes, e.what()));
            return;
        }
        std::vector<int> counts;
        for (int n = 1; n <= out_.request.most_probes / 4; n *= 2) counts.push_back(n);
        if (counts.empty()) return;
        const std::vector<int> chosen = places_that_see_most(measure_.world(), checked(), places, counts.back(), options_);
        for (const bool by_sight : {false, true})
            for (const int n : counts) {
                probes::PlacementParams own = params_.placement;
                own.count = n;
                Buffer<glm::vec4> some;
                for (int k = 0; by_sight && k < n; ++k) some.push_back(places[std::size_t(chosen[std::size_t(k)])]);
                if (!by_sight)
                    some = probes::place_probes(measure_.world().geometry, *measure_.world().query, own, options_).probes;
                add(measure_.uncut_rung(some, own, by_sight ? "chosen by what they see" : "as placed"));
            }
    }

    // More than one number at once: whether the default lies on the front.
    void climb_products() {
        for (const double more : {0.25, 1.0, 4.0, 16.0}) {
            const int count = int(more * out_.probes);
            if (count < 1 || (more > 1 && count > out_.request.most_probes)) continue;
            Params p = params_;
            p.placement.count = count;
            const std::string probes = fmt::format("probes.count={}", count);
            for (const int overlaps : {3, params_.placement.overlaps})
                for (const int degree : {3, 5, 7}) {
                    p.placement.overlaps = overlaps, p.degree = degree;
                    climb_cuts(p, fmt::format("{} probes.overlaps={} probes.degree={}", probes, overlaps, degree));
                }
            p.placement.overlaps = 3, p.degree = params_.degree, p.receiver_rays = 128;
            climb_cuts(p, probes + " probes.overlaps=3 probes.receiver_rays=128");
        }
    }

    // One transport, cut in three ways.
    void climb_cuts(const Params& params, const std::string& settings) {
        const std::optional<LadderBaked> made = climb("products", "products", 0, params, settings);
        if (!made) return;
        Params cut = params;
        cut.threshold = std::min(1.0f, 6 * params.threshold);
        add(measure_.rung_of(measure_.cut_again(*made, cut), "products", "products", 0,
                             fmt::format("{} probes.threshold={:g}", settings, cut.threshold)));
        cut.by_size_only = true;
        add(measure_.rung_of(measure_.cut_again(*made, cut), "products", "products", 0,
                             settings + " probes.by_size_only=true"));
    }

    const Params& params_;
    const RunOptions& options_;
    const std::function<void(const std::string&)>& progress_;
    LadderMeasure measure_;
    Ladder out_;
};

}  // namespace

Ladder climb(const Scene& scene, const Params& params, const LadderRequest& request, const RunOptions& options,
             const std::function<void(const std::string&)>& progress) {
    return Climber(scene, params, request, options, progress).run();
}

}  // namespace plumb::cli
