// Image-space radiosity: from the G-buffers and direct light of all sources to indirect light of every pixel.
#include <fmt/format.h>

#include "core/hash.h"
#include "gi/frame/filters.h"
#include "gi/frame/frame_graph.h"
#include "gi/isr/isr.h"

namespace plumb::frame {

namespace {

std::string bounce_form(int bounce) { return bounce == 1 ? "" : fmt::format("bounce {}", bounce); }

// Adds the nodes, and counts the images of which there are several (IsrBuffers).
class Adder {
  public:
    Adder(Context& c, Nodes& nodes) : c_(c), params_(c.settings.isr), nodes_(nodes) {
        // The wider view takes the frame's place.
        const bool guarded = c.views.size() > 1 && c.views[1].kind == ViewKind::guard;
        for (int v = guarded ? 1 : 0; v < drawn(); ++v) sources_.push_back(v);
    }

    void add() {
        for (int v = 0; v < drawn(); ++v) {
            add_downsample("surface", isr::Coarse::surface, "isr lit", v);
            if (v > 0 || sources_.front() == 0) add_downsample("radiosity", isr::Coarse::radiosity, "isr", v);
        }
        for (int v = 0; v < drawn(); ++v)
            if (c_.views[std::size_t(v)].kind == ViewKind::camera) add_unseen(v);
        if (params_.bounces > 1) add_downsample("reflectance", isr::Coarse::reflectance, "isr", 0);
        for (int bounce = 1; bounce <= params_.bounces; ++bounce) {
            if (bounce > 1) add_bounce(bounce);
            for (const int view : sources_)
                if (c_.views[std::size_t(view)].kind == ViewKind::camera)
                    add_gather_camera(bounce, view);
                else
                    add_gather(bounce, view);
        }
        add_ssao();
        if (params_.blur != isr::Blur::none) {
            add_blur("horizontal", isr::Direction::horizontal, &IsrBuffers::lit, &IsrBuffers::blurred_across);
            add_blur("vertical", isr::Direction::vertical, &IsrBuffers::blurred_across, &IsrBuffers::blurred);
        }
        if (!native()) add_upsample();
    }

  private:
    template <class Kernel>
    PlannedNode begin(const std::string& work, const std::string& why, const std::string& tap, glm::ivec2 size,
                      double turns_a_pixel = 1) {
        PlannedNode node = begin_node(c_, stage<Kernel>(), work, why, double(size.x) * size.y * turns_a_pixel);
        node.results = {{"result", "", tap}};
        node.size = [=] { return size; };
        return node;
    }
    template <class InputsOf, class To>
    void push(PlannedNode node, InputsOf inputs, To result) {
        compute(c_, node, params_, inputs, result);
        node.in_steps = true;
        nodes_.push_back(std::move(node));
    }

    // Squares of coarse pixels that see a surface.
    std::function<raster::Covered()> coarse_tiles() {
        return [&c = c_] { return covered_by(c.frame.isr.surface); };
    }
    // No light, and nothing occluded.
    template <class To>
    static std::function<void()> open(glm::ivec2 size, To result) {
        return [=] { result() = Image4(size.x, size.y, glm::vec4(0, 0, 0, 1)); };
    }

    bool native() const { return params_.resolution == isr::Resolution::native; }
    int side() const { return isr::coarse_side(params_); }
    glm::ivec2 coarse() const { return isr::coarse_size(c_.size, side()); }
    int drawn() const { return views_before_mirrors(c_.views); }
    glm::ivec2 coarse_of(int view) const { return isr::coarse_size(c_.views[std::size_t(view)].size, side()); }
    isr::CoarseCamera frame_camera() const { return isr::coarse_camera(c_.scene.camera, c_.size, 0, side()); }
    isr::CoarseCamera camera_of(int view) const {
        const IsrView& v = c_.views[std::size_t(view)];
        return v.kind == ViewKind::camera ? isr::coarse_camera(v.camera, v.size, 0, side()) : frame_camera();
    }
    static Image4& surface(Context& c, int view) {
        return view == 0 ? c.frame.isr.surface : c.frame.views[std::size_t(view)].surface;
    }
    static Image4& radiosity(Context& c, int view) {
        return view == 0 ? c.frame.isr.radiosity : c.frame.views[std::size_t(view)].radiosity;
    }
    static Image4& coarse_image(Context& c, isr::Coarse what, int view) {
        if (what == isr::Coarse::reflectance) return c.frame.isr.reflectance;
        return what == isr::Coarse::surface ? surface(c, view) : radiosity(c, view);
    }
    // height: of the image that the samples lie in, without a guard band.
    isr::Pattern gather_pattern(int height) const { return isr::gather_pattern(params_, height); }

    void add_downsample(const std::string& form, isr::Coarse what, const std::string& work, int view) {
        PlannedNode node = begin<isr::DownsampleKernel>(work, "gathers read it", "mean", coarse_of(view));
        set_form(node, form), set_view(c_, node, view);
        node.covered = [] { return raster::Covered(); };  // all of them
        push(std::move(node),
             [=, &c = c_] {
                 const raster::GBuffer& g = c.gbuffer(view);
                 isr::DownsampleInputs in{what, &g.position, &g.normal, &g.albedo, &g.emission, &c.direct(view)};
                 in.near = c.scene.camera.near, in.far = c.scene.camera.far;
                 return in;
             },
             [=, &c = c_]() -> Image4& { return coarse_image(c, what, view); });
    }

    // Of a camera's surfaces those remain that no view before it sees.
    void add_unseen(int camera) {
        int before = -1;  // index of what is left by the pass before
        for (const int other : sources_) {
            if (other >= camera) continue;
            const IsrView& view = c_.views[std::size_t(other)];
            PlannedNode node = begin<isr::UnseenKernel>("isr", "gathers read it", "unseen", coarse_of(camera));
            set_form(node, view.kind == ViewKind::own ? "frame" : view.name), set_view(c_, node, camera);
            const int made = c_.isr_unseen++;
            push(std::move(node),
                 [=, &c = c_, eye = camera_of(camera), seen_from = camera_of(other), margin = view.margin] {
                     isr::UnseenInputs in;
                     in.surface = before < 0 ? &surface(c, camera) : &c.frame.isr.unseen[std::size_t(before)];
                     in.camera = eye;
                     in.view_surface = &surface(c, other);
                     in.view = seen_from;
                     in.margin = margin;
                     return in;
                 },
                 [=, &c = c_]() -> Image4& { return c.frame.isr.unseen[std::size_t(made)]; });
            before = made;
        }
        last_unseen_[camera] = before;
    }

    void add_bounce(int bounce) {
        const int view = sources_.front(), gathered = c_.isr_gathers - 1, made = c_.isr_bounces++;
        PlannedNode node = begin<isr::BounceKernel>("isr", "gathers read it", "radiosity", coarse_of(view));
        set_form(node, bounce_form(bounce)), set_view(c_, node, view);
        push(std::move(node),
             [=, &c = c_, margin = c_.views[std::size_t(view)].margin] {
                 isr::BounceInputs in;
                 in.radiosity = &radiosity(c, view);
                 in.reflectance = &c.frame.isr.reflectance;
                 in.gathered = &c.frame.isr.gathered[std::size_t(gathered)];
                 in.margin = margin;
                 return in;
             },
             [=, &c = c_]() -> Image4& { return c.frame.isr.radiosities[std::size_t(made)]; });
    }

    // What all gathers add to, and what is told of them.
    void push_gather(PlannedNode node, int bounce, int view, auto inputs) {
        set_form(node, bounce_form(bounce)), set_view(c_, node, view);
        node.covered = coarse_tiles();
        const int made = c_.isr_gathers++;
        auto result = [=, &c = c_]() -> Image4& { return c.frame.isr.gathered[std::size_t(made)]; };
        compute(c_, node, params_, inputs, result);
        node.run = [=, run = node.run, &c = c_](const RunOptions& options, graph::NodeRun& row) {
            run(options, row);
            const isr::Excess excess = isr::excess_of(c.frame.isr.surface, result());
            if (excess.share > 0)
                row.reason += fmt::format("; form factors sum to more than 1, at most {:.4g}, at {:.3g} % of the pixels",
                                           excess.largest, 100 * excess.share);
        };
        node.in_steps = true;
        nodes_.push_back(std::move(node));
    }
    PlannedNode begin_gather(const StageBinding& binding) {
        const glm::ivec2 size = coarse();
        PlannedNode node = begin_node(c_, binding, "isr", "indirect light",
                                      double(size.x) * size.y * isr::sample_count(params_.rings));
        node.size = [=] { return size; };
        node.results = {{"result", "", "irradiance"}};
        return node;
    }

    void add_gather(int bounce, int view) {
        const bool first = view == sources_.front();
        const int before = first ? -1 : c_.isr_gathers - 1;
        push_gather(begin_gather(stage<isr::GatherKernel>()), bounce, view,
                    [=, &c = c_, pattern = std::make_shared<const isr::Pattern>(gather_pattern(coarse().y)), eye = frame_camera(),
                     margin = c_.views[std::size_t(view)].margin] {
                        isr::GatherInputs in;
                        in.surface = &c.frame.isr.surface;
                        in.source_surface = &surface(c, view);
                        in.source_radiosity = bounce > 1 && first ? &c.frame.isr.radiosities[std::size_t(bounce - 2)]
                                                                  : &radiosity(c, view);
                        if (before >= 0) in.before = &c.frame.isr.gathered[std::size_t(before)];
                        in.camera = eye;
                        in.margin = margin;
                        in.pattern = pattern.get();
                        in.seed = c.settings.seed;
                        return in;
                    });
    }

    void add_gather_camera(int bounce, int view) {
        const int before = c_.isr_gathers - 1, unseen = last_unseen_.at(view);
        push_gather(begin_gather(stage<isr::GatherCameraKernel>()), bounce, view,
                    [=, &c = c_, pattern = std::make_shared<const isr::Pattern>(gather_pattern(coarse_of(view).y)), eye = frame_camera(),
                     source = camera_of(view)] {
                        isr::CameraGatherInputs in;
                        in.surface = &c.frame.isr.surface;
                        in.camera = eye;
                        in.source_surface = &c.frame.isr.unseen[std::size_t(unseen)];
                        in.source_radiosity = &radiosity(c, view);
                        in.source_camera = source;
                        in.before = &c.frame.isr.gathered[std::size_t(before)];
                        in.pattern = pattern.get();
                        in.seed = c.settings.seed;
                        return in;
                    });
    }

    void add_ssao() {
        const int source = sources_.front(), gathered = c_.isr_gathers - 1;
        PlannedNode node = begin<isr::SsaoKernel>("isr access", "accessibility", "accessibility", coarse(),
                                                  isr::sample_count(params_.ssao_rings));
        node.results = {{"accessibility", "", "accessibility", 3, 1}};
        node.covered = coarse_tiles();
        // What goes through it goes on without it.
        const bool last = native() && params_.blur == isr::Blur::none;
        auto result = [=, &c = c_]() -> Image4& { return last ? c.frame.indirect : c.frame.isr.lit; };
        node.leave_out = [=, &c = c_] { result() = c.frame.isr.gathered[std::size_t(gathered)]; };
        node.reads_left_out = [=, &c = c_](graph::Reads& r) { r.image(c.frame.isr.gathered[std::size_t(gathered)]); };
        push(std::move(node),
             [=, &c = c_, pattern = std::make_shared<const isr::Pattern>(isr::ssao_pattern(params_)), eye = frame_camera(),
              margin = c_.views[std::size_t(source)].margin] {
                 isr::SsaoInputs in;
                 in.surface = &c.frame.isr.surface;
                 in.source_surface = &surface(c, source);
                 in.gathered = &c.frame.isr.gathered[std::size_t(gathered)];
                 in.camera = eye;
                 in.margin = margin;
                 in.pattern = pattern.get();
                 // Rotations of their own.
                 in.seed = std::uint32_t(pcg(std::int32_t(c.settings.seed)));
                 return in;
             },
             result);
    }

    void add_blur(const std::string& form, isr::Direction direction, Image4 IsrBuffers::*from, Image4 IsrBuffers::*to) {
        PlannedNode node = begin<isr::BlurKernel>("isr lit", "indirect light without its noise", "irradiance", coarse(),
                                                  2 * isr::resolved(params_).blur_radius + 1);
        set_form(node, form);
        node.covered = coarse_tiles();
        // At native resolution the last pass makes what upsampling would.
        const bool last = native() && direction == isr::Direction::vertical;
        auto result = [=, &c = c_]() -> Image4& { return last ? c.frame.indirect : c.frame.isr.*to; };
        node.leave_out = open(coarse(), result);
        push(std::move(node),
             [=, &c = c_, camera = frame_camera()] {
                 isr::BlurInputs in{&(c.frame.isr.*from), &c.frame.isr.surface, camera};
                 in.direction = direction;
                 return in;
             },
             result);
    }

    void add_upsample() {
        PlannedNode node = begin<isr::UpsampleKernel>("isr lit", "indirect light of every pixel", "irradiance", c_.size);
        auto result = [&c = c_]() -> Image4& { return c.frame.indirect; };
        node.leave_out = open(c_.size, result);
        Image4 IsrBuffers::*from = params_.blur == isr::Blur::none ? &IsrBuffers::lit : &IsrBuffers::blurred;
        push(std::move(node),
             [=, &c = c_] {
                 const raster::GBuffer& g = c.frame.gbuffer;
                 isr::UpsampleInputs in{&(c.frame.isr.*from), &c.frame.isr.surface, &g.position, &g.normal};
                 in.near = c.scene.camera.near, in.far = c.scene.camera.far;
                 return in;
             },
             result);
    }

    Context& c_;
    const isr::IsrParams& params_;
    Nodes& nodes_;
    std::vector<int> sources_;        // views whose surfaces send light, in the order in which they are gathered
    std::map<int, int> last_unseen_;  // of each camera: index into IsrBuffers::unseen
};

}  // namespace

void add_isr(Context& c, Nodes& nodes) {
    if (gathers_isr(c.settings)) Adder(c, nodes).add();
}

}  // namespace plumb::frame
