// The filters of indirect light (filters.h): of the points before gathers, and of their sum.
#include "gi/filter/filter.h"
#include "gi/frame/filters.h"

#include "gi/frame/frame_graph.h"

namespace plumb::frame {

bool halves_indirect(const Settings& settings) {
    return settings.method == Method::rsm && settings.indirect.resolution == filter::Resolution::half;
}

bool sums_gathers(const Settings& settings) { return !gathers_isr(settings) && !lights_probes(settings) && !solves_radiosity(settings); }

filter::Blur blur_of(const Settings& settings) {
    if (settings.method != Method::rsm) return filter::Blur::none;
    if (settings.indirect.blur != filter::Blur::automatic) return settings.indirect.blur;
    const bool samples = settings.rsm.gather == rsm::Gather::disc || settings.rsm.gather == rsm::Gather::paths;
    return samples && !reuses_light(settings) ? filter::Blur::separable : filter::Blur::none;
}

bool filters_indirect(const Settings& settings) {
    return halves_indirect(settings) || reuses_light(settings) || blur_of(settings) != filter::Blur::none;
}

glm::ivec2 gather_size(const Settings& settings, glm::ivec2 frame_size) {
    return halves_indirect(settings) ? filter::half_size(frame_size) : frame_size;
}

raster::Covered covered_by(const Image4& normal) {
    raster::Covered tiles({normal.width, normal.height});
    for (int y = 0; y < normal.height; ++y)
        for (int x = 0; x < normal.width; ++x)
            if (glm::vec3(normal(x, y)) != glm::vec3(0))
                tiles.any[std::size_t(y >> raster::Covered::shift) * std::size_t(tiles.tiles.x) +
                          std::size_t(x >> raster::Covered::shift)] = 1;
    return tiles;
}

namespace {

// No light, and the depth that goes along with it.
void light_nothing(Context& c, PlannedNode& node, const std::function<Image4&()>& result) {
    node.leave_out = [=, &c, size = node.size] {
        Image4& image = result() = Image4(size().x, size().y);
        for (std::size_t i = 0; i < image.size(); ++i) image.texels[i].w = c.frame.gbuffer.position.texels[i].w;
    };
    node.reads_left_out = [&c](graph::Reads& r) { r.image(c.frame.gbuffer.position); };
}

void add_reduce(Context& c, const std::string& form, const Image4 raster::GBuffer::*of, Image4 Frame::*half, Nodes& nodes) {
    const glm::ivec2 size = gather_size(c.settings, c.size);
    PlannedNode node = begin_node(c, stage<filter::ReduceKernel>(), "filter", "gathers read it",
                                  double(c.size.x) * c.size.y / 4);
    set_form(node, form);
    node.direct = true;
    node.results = {{"reduced " + form, "", "value"}};
    node.size = [=] { return size; };
    compute(c, node, c.settings.indirect, [=, &c] { return filter::ReduceInputs{&(c.frame.gbuffer.*of)}; },
            [=, &c]() -> Image4& { return c.frame.*half; });
    node.in_steps = true;
    nodes.push_back(std::move(node));
}

void add_upsample(Context& c, const Image4 Frame::*from, Image4 Frame::*to, Nodes& nodes) {
    PlannedNode node = begin_node(c, stage<filter::UpsampleKernel>(), "filter", "indirect light of every pixel",
                                  double(c.size.x) * c.size.y);
    auto result = [=, &c]() -> Image4& { return c.frame.*to; };
    light_nothing(c, node, result);
    node.results = {{"irradiance", "", "irradiance"}};
    compute(c, node, c.settings.indirect,
            [=, &c] {
                const Frame& f = c.frame;
                return filter::UpsampleInputs{&(f.*from), &f.half_position, &f.half_normal, &f.gbuffer.position,
                                              &f.gbuffer.normal};
            },
            result);
    node.in_steps = true;
    nodes.push_back(std::move(node));
}

void add_blur(Context& c, const std::string& form, filter::Direction direction, const Image4 Frame::*from,
              Image4 Frame::*to, Nodes& nodes) {
    const double kernel = c.settings.indirect.kernel;
    PlannedNode node = begin_node(c, stage<filter::BlurKernel>(), "filter", "indirect light without its noise",
                                  double(c.size.x) * c.size.y * kernel * (form.empty() ? kernel : 1));
    set_form(node, form);
    auto result = [=, &c]() -> Image4& { return c.frame.*to; };
    light_nothing(c, node, result);
    node.results = {{"irradiance", "", "irradiance"}};
    compute(c, node, c.settings.indirect,
            [=, &c] {
                filter::BlurInputs in{&(c.frame.*from), &c.frame.gbuffer.position, &c.frame.gbuffer.normal};
                in.direction = direction;
                return in;
            },
            result);
    node.in_steps = true;
    nodes.push_back(std::move(node));
}

}  // namespace

void add_filters_before(Context& c, Nodes& nodes) {
    if (!halves_indirect(c.settings)) return;
    add_reduce(c, "position", &raster::GBuffer::position, &Frame::half_position, nodes);
    add_reduce(c, "normal", &raster::GBuffer::normal, &Frame::half_normal, nodes);
}

// The last of them writes the indirect light.
void add_filters_after(Context& c, Nodes& nodes) {
    if (!filters_indirect(c.settings)) return;
    const bool half = halves_indirect(c.settings);
    const filter::Blur blur = blur_of(c.settings);
    if (reuses_light(c.settings)) add_reuse(c, nodes);
    const Image4 Frame::*sum = reuses_light(c.settings) ? &Frame::reused : &Frame::gathered;
    if (half) add_upsample(c, sum, blur == filter::Blur::none ? &Frame::indirect : &Frame::upsampled, nodes);
    const Image4 Frame::*sharp = half ? &Frame::upsampled : sum;
    if (blur == filter::Blur::full)
        add_blur(c, "", filter::BlurInputs{}.direction, sharp, &Frame::indirect, nodes);
    if (blur != filter::Blur::separable) return;
    add_blur(c, "horizontal", filter::Direction::horizontal, sharp, &Frame::blurred_across, nodes);
    add_blur(c, "vertical", filter::Direction::vertical, &Frame::blurred_across, &Frame::indirect, nodes);
}

}  // namespace plumb::frame
