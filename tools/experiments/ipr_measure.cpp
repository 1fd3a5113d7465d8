// plumb experiment ipr: the settings of the thesis' tables and figures, measured.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "gi/probes/run_stages.h"
#include "gi/probes/sky_probe.h"
#include "io/file.h"
#include "tools/experiments/bake_sizes.h"
#include "tools/experiments/ipr_parts.h"

namespace plumb::cli {

namespace {

struct Column {
    const char* name;
    int start, probes;   // start: where the search for a lightmap's size begins
    IprThesis thesis;
};
// Tables 5.1 and 5.2.
const Column table_1[] = {{"P0", 512, 1, {65011, 0, 5.29, 3.84}}, {"P1", 512, 3, {65011, 0, 5.67, 5.70}}, {"P2", 512, 11, {65011, 0, 6.56, 25.14}},
                          {"P3", 512, 30, {65011, 0, 7.55, 36.12}}, {"P4", 512, 78, {65011, 0, 10.28, 54.31}}};
const Column table_2[] = {{"R0", 64, 7, {712, 2, 1.61, 0.09}}, {"R1", 128, 7, {3369, 4, 1.76, 0.45}}, {"R2", 256, 7, {15608, 36, 3.02, 2.06}},
                          {"R3", 512, 7, {67662, 103, 6.15, 8.75}}, {"R4", 1024, 7, {282403, 428, 19.19, 37.8}}};

constexpr int quick_share = 64;  // of the thesis' receivers in table 5.1

// The thesis' choices in place of the defaults; what the scene file or --set says is the default's.
probes::BakeParams published_choices(probes::BakeParams p) {
    p.placement.overlaps = 10, p.placement.least = 8;
    p.receiver_rays = 512, p.relight_rays = 512, p.degree = 7, p.singular_values = 32, p.threshold = 0.005f;
    p.gather = probes::Gather::interpolated;
    return p;
}

class Measure {
  public:
    Measure(const Scene& scene, const frame::Settings& settings, const IprRequest& request, const RunOptions& options, const IprTell& tell)
        : scene_(scene), settings_(settings), request_(request), options_(options), tell_(tell), bench_(scene, settings, request, options) {
        result_.scene = io::stem_of(scene.name);
    }

    IprResult run() {
        if (request_.wants("tables")) {
            add_columns("5.1", "probes", std::begin(table_1), std::end(table_1) - (request_.quick ? 2 : 0), request_.quick ? quick_share : 1);
            add_columns("5.2", "receivers", std::begin(table_2), std::end(table_2) - (request_.quick ? 3 : 0), 1);
        }
        if (request_.wants("graphs")) add_graphs();
        if (request_.wants("figures")) add_figures();
        if (request_.wants("goals")) add_goals();
        if (request_.wants("quads")) add_quads();
        if (request_.wants("lightmap")) {
            tell_("lightmap");
            probes::BakeParams params = settings_.probes;
            params.lightmap_size = size_for(params, request_.quick ? 700 : 16000, 128);
            result_.lightmap = bench_.lightmap(params);
        }
        const std::function<int(const probes::BakeParams&, int, int)> size = [this](const probes::BakeParams& p, int receivers, int start) { return size_for(p, receivers, start); };
        const IprPart part{scene_, settings_, request_, options_, tell_, bench_, result_, size};
        if (request_.wants("spatial")) measure_spatial(part);
        if (request_.wants("objects")) measure_objects(part);
        if (request_.wants("lod")) measure_lod(part);
        return std::move(result_);
    }

  private:
    probes::BakeParams as_published() const { return published_choices(settings_.probes); }
    // Known sizes are asked once.
    int size_for(const probes::BakeParams& params, int receivers, int start) {
        int& size = sizes_[receivers];
        if (size == 0) size = lightmap_for(scene_, params, receivers, start, options_);
        return size;
    }

    IprRow measure(const IprVariant& v) {
        tell_(v.name + (v.settings.empty() ? "" : ": " + v.settings));
        return bench_.row(v);
    }

    void add_columns(const std::string& id, const std::string& what, const Column* first, const Column* last, int share) {
        IprTable table;
        table.id = "table " + id, table.title = "number of " + what;
        table.notes = "with the thesis' choices: 10 probes of a receiver, 512 rays of each receiver and probe, degree 7, 32 singular values of a cluster";
        for (const Column* c = first; c != last; ++c) {
            IprVariant v;
            v.name = c->name, v.bake = as_published(), v.thesis = c->thesis, v.dots = id == "5.1";  // figure 5.3
            const int wanted = c->thesis.receivers / share;
            v.bake.placement.count = c->probes, v.bake.lightmap_size = size_for(v.bake, wanted, c->start);
            if (const int found = receivers_at(scene_, v.bake, v.bake.lightmap_size, options_); found > 1.25 * wanted) {
                table.left_out.push_back(fmt::format("{}: the smallest lightmap with room for the scene's charts has {} receivers", c->name, found));
                continue;
            }
            v.settings = fmt::format("{} probes, {} texels a side", c->probes, v.bake.lightmap_size);
            table.rows.push_back(measure(v));
        }
        if (share > 1) table.notes += fmt::format("; quick: 1/{} of the thesis' receivers", share);
        if (!table.rows.empty()) against(table.rows.back(), table.rows);
        result_.tables.push_back(std::move(table));
    }

    IprVariant figure(const std::string& name, const std::string& settings) {
        IprVariant v;
        v.name = name, v.settings = settings, v.bake = as_published();
        v.bake.placement.count = 11;
        v.bake.lightmap_size = size_for(v.bake, request_.quick ? 700 : 15608, 256);
        return v;
    }
    void add_figure(const std::string& id, const std::string& title, const std::string& notes, const std::vector<IprVariant>& variants) {
        IprTable table{id, title, notes, {}, {}};
        for (const IprVariant& v : variants) table.rows.push_back(measure(v));
        if (!table.rows.empty()) against(table.rows.front(), table.rows);
        result_.tables.push_back(std::move(table));
    }

    void add_figures() {
        std::vector<IprVariant> escapes;
        for (const auto& [name, escape] : {std::pair("1 nothing", probes::Escapes::nothing), {"2 same direction", probes::Escapes::same_direction},
                                           {"3 visible probes", probes::Escapes::visible_probes}, {"4 all probes", probes::Escapes::all_probes},
                                           {"the sky, a probe", probes::Escapes::sky}}) {
            escapes.push_back(figure(name, std::string("escapes, 11 probes")));
            escapes.back().bake.escapes = escape;
        }
        add_figure("figure 5.9", "what rays that meet nothing bring", "under a sky that sends light the first loses it; the thesis has none", escapes);

        std::vector<IprVariant> weights = {figure("none", "weighting"), figure("W", "weighting = published")};
        weights[1].bake.weighting = probes::Weighting::published;
        add_figure("figure 5.11", "weights of a ray's length", "W(x) = 1 - 1 / (2 pi x^2 + 1); what the thesis holds it against, W(x) = x, no bake has: it depends on the unit of length even more",
                   weights);

        std::vector<IprVariant> shifts = {figure("moved", "test_rays = 64"), figure("not moved", "test_rays = 0")};
        shifts[1].bake.test_rays = 0;
        add_figure("figures 5.12, 5.15", "receivers moved out of what they lie in",
                   "errors at receivers are of their own places, those at pixels of what is seen", shifts);

        add_aura();

        std::vector<IprVariant> feedback = {figure("rho / pi", "feedback = corrected")};
        for (const double c : {0.0, 0.1, 0.19, 0.25, 0.3}) {
            feedback.push_back(figure(fmt::format("c = {:g}", c), fmt::format("feedback = constant, reflection = {:g}", c)));
            feedback.back().run.feedback = probes::Feedback::constant, feedback.back().run.reflection = float(c);
        }
        feedback.push_back(figure("rho", "feedback = material"));
        feedback.back().run.feedback = probes::Feedback::material;
        add_figure("figure 3.32", "what comes back from a surface", "a constant from 1/pi = 0.318 on grows from round to round in a closed scene", feedback);
    }

    // Figure 5.13: the finer the lightmap, the narrower the bright edge of what touches.
    void add_aura() {
        IprSheet sheet{"figure 5.13", "bright edges where objects touch, by the density of receivers", "contacts: pixels a quarter of whose view is taken by what is within a fiftieth "
                       "of the scene's diagonal; receivers are not moved", {{"receivers"}, {"ms", 3}, {"SSIM", 4}, {"SSIM truth", 4}}, {}, {}, {}};
        add_error_heads(sheet.heads, "pixels");
        add_error_heads(sheet.heads, "contacts");
        std::vector<IprRow> rows;
        const std::vector<int> wanted = request_.quick ? std::vector<int>{700, 1400} : std::vector<int>{3369, 15608, 67662, 282403};
        for (const int receivers : wanted) {
            IprVariant v = figure(fmt::format("{} receivers", receivers), "test_rays = 0");
            v.bake.lightmap_size = size_for(v.bake, receivers, 256), v.bake.test_rays = 0, v.contacts = true;
            rows.push_back(measure(v));
        }
        against(rows.back(), rows);
        for (const IprRow& r : rows) {
            IprSheetRow row{r.name, r.settings, {double(r.receivers), r.median_ms(), r.ssim, r.ssim_truth}, {{"", r.display}, {"error of the indirect light", r.error}}};
            add_error_values(row.values, r.at_pixels), add_error_values(row.values, r.at_contacts);
            sheet.rows.push_back(std::move(row));
        }
        result_.sheets.push_back(std::move(sheet));
    }

    // Figures 5.5 and 5.8: every number of probes with every number of receivers.
    void add_graphs() {
        IprTable table;
        table.id = "figures 5.5, 5.8", table.title = "probes by receivers", table.notes = "with the thesis' choices";
        const std::vector<int> probes = request_.quick ? std::vector<int>{1, 4} : std::vector<int>{1, 3, 11, 30, 78};
        const std::vector<int> receivers = request_.quick ? std::vector<int>{500, 1000} : std::vector<int>{3369, 15608, 67662, 282403};
        for (const int n : receivers)
            for (const int p : probes) {
                IprVariant v;
                v.name = fmt::format("{} probes, {} receivers", p, n), v.bake = as_published();
                v.bake.placement.count = p, v.bake.lightmap_size = size_for(v.bake, n, 256);
                v.settings = fmt::format("{} texels a side", v.bake.lightmap_size), v.thesis.receivers = n;
                table.rows.push_back(measure(v));
            }
        against(table.rows.back(), table.rows);
        for (IprRow& r : table.rows) r.radiance = {}, r.display = {}, r.error = {};  // its pictures are those of tables 5.1 and 5.2
        result_.tables.push_back(std::move(table));
    }

    // The scene's own bake, but of no more receivers than an experiment can judge in its time.
    probes::BakeParams own_bake() {
        probes::BakeParams p = settings_.probes;
        const int most = request_.quick ? 700 : 65011;
        if (p.lightmap_size == 0 && probes::expected_bake(scene_, p).receivers > most) p.lightmap_size = size_for(p, most, request_.quick ? 64 : 512);
        return p;
    }

    void add_goals() {
        const probes::BakeParams own = own_bake();
        std::vector<IprVariant> all;
        const auto add = [&](const std::string& name, const std::string& settings) -> IprVariant& {
            IprVariant v;
            v.name = name, v.settings = settings, v.bake = own;
            all.push_back(v);
            return all.back();
        };
        add("default", own.lightmap_size > 0 ? fmt::format("lightmap of {} texels a side", own.lightmap_size) : "");
        IprVariant& rays = add("shadow rays", "in place of shadow maps");
        rays.shadow_rays = true;
        IprVariant& maps = add("shadow maps", "of twice as many texels a side");
        maps.shadow_scale = 2;
        IprVariant& relight = add("relight rays", fmt::format("{}", 4 * own.relight_rays));
        relight.bake.relight_rays = 4 * own.relight_rays;
        IprVariant& degree = add("degree", fmt::format("{}: one less, for there are no more", std::max(own.degree - 1, 0)));
        degree.bake.degree = std::max(own.degree - 1, 0);
        IprVariant& values = add("clusters", "64 singular values, threshold a tenth");
        values.bake.singular_values = 64, values.bake.threshold = own.threshold / 10;
        IprVariant& receiver = add("receivers' rays", fmt::format("{}", 4 * own.receiver_rays));
        receiver.bake.receiver_rays = 4 * own.receiver_rays;
        const int standing = probes::standing_probes(bench_.bake(own).placement.probes);
        const auto probes_of = [&](IprVariant& v, int times) {
            v.bake.placement.count = times * standing;
            v.settings = fmt::format("{}", v.bake.placement.count);
        };
        probes_of(add("probes", ""), 4);
        if (!request_.quick) probes_of(add("probes", ""), 16);
        IprVariant& together = add("together", "");
        probes_of(together, 4);
        together.bake.relight_rays = 4 * own.relight_rays, together.bake.receiver_rays = 4 * own.receiver_rays;
        together.settings = fmt::format("{} probes, {} relight rays, {} rays of a receiver", together.bake.placement.count, together.bake.relight_rays,
                                        together.bake.receiver_rays);
        IprTable table{"goal", "error with converged bounces, each resource changed once", "the default bake; every row changes one number of it", {}, {}};
        for (const IprVariant& v : all) table.rows.push_back(measure(v));
        against(table.rows.front(), table.rows);
        result_.goal = goal_of(result_.scene, table);
        result_.tables.push_back(std::move(table));
    }

    void add_quads() {
        tell_("small emissive quads");
        const Scene room = ipr_quad_room();
        frame::Settings settings = frame::settings_of(room);
        probes::BakeParams params;
        params.receivers_per_m2 = request_.quick ? 4 : 40;
        if (request_.quick) params.placement.least = 16;
        settings.probes = params;
        IprRequest request = request_;
        request.open = 1;
        IprBench bench(room, settings, request, options_);
        result_.quads = bench.quads(params);
    }

    const Scene& scene_;
    const frame::Settings& settings_;
    const IprRequest& request_;
    const RunOptions& options_;
    const IprTell& tell_;
    IprBench bench_;
    IprResult result_;
    std::map<int, int> sizes_;
};

}  // namespace

probes::BakeParams as_published(const IprPart& part) { return published_choices(part.settings.probes); }

IprGoal goal_of(const std::string& scene, const IprTable& table) {
    IprGoal goal;
    const auto begins = [&](const char* name) { return scene.rfind(name, 0) == 0; };
    goal.most = begins("cornell") ? 0.03 : begins("hall") || begins("rooms") ? 0.06 : 0;
    goal.reached = table.rows.front().at_receivers.mean;
    for (const IprRow& r : table.rows) {
        if (!r.refused.empty()) continue;
        const double lowered = 1 - r.at_receivers.mean / goal.reached;
        if (lowered > goal.lowered) goal.lowered = lowered, goal.limit = r.name + (r.settings.empty() ? "" : " (" + r.settings + ")");
    }
    return goal;
}

IprResult measure_ipr(const Scene& scene, const frame::Settings& settings, const IprRequest& request, const RunOptions& options, const IprTell& tell) {
    return Measure(scene, settings, request, options, tell).run();
}

}  // namespace plumb::cli
