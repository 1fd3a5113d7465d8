#include "tools/plumb/explain_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tools/page/markup.h"
#include "tools/plumb/explain_marks.h"
#include "tools/plumb/explain_pictures.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

using page::Cell;
using page::escaped;
using page::Page;
using parity::TwoValues;

constexpr int map_px = 512, frame_px = 312, near_px = 192;  // on the page
const Samples no_samples;
constexpr int kept_texels = 512, near_texels = 33;

// ---- Pictures -----------------------------------------------------------------------------------------------------

// One picture of one stage: an input or output, and what is known of it.
struct Shown {
    const Slot& slot;
    const Array& array;
    int layer = 0;
    bool of_frame = false;  // the pixel is one of its texels
    bool read_at = false;   // samples lie on it
};

struct Marks {
    const Samples& samples;
    const std::string key;
    glm::ivec2 pixel;
    std::optional<glm::dvec2> projection;
    std::string triangle = "";
};

// The last value of that name outside of samples.
const TapValue* single(const std::vector<TapValue>& values, const std::string& name) {
    const TapValue* found = nullptr;
    for (const TapValue& v : values)
        if (v.name == name && v.sample < 0 && !v.value.empty()) found = &v;
    return found;
}

std::optional<glm::dvec2> projection_of(const std::vector<TapValue>& values) {
    for (const auto& [name, middle] : {std::pair("projection", 0.0), std::pair("centre", 0.5), std::pair("picked", 0.5)})
        if (const TapValue* v = single(values, name); v && v->value.size() == 2)
            return glm::dvec2(v->value[0] + middle, v->value[1] + middle);
    return {};
}

// Samples lie on maps; of a stage that reads none, on the images of the frame.
std::vector<Shown> shown_of(const ExplainedStage& stage, const Samples& samples) {
    auto images = [&](const std::vector<Slot>& slots, const Bundle& from) {
        std::vector<Shown> out;
        for (const Slot& slot : slots)
            if (const Array* array = find(from, slot.name))
                for (int layer = 0; layer < layers_of(slot, *array); ++layer)
                    out.push_back({slot, *array, layer, layer_size(slot, *array) == stage.data->size && slot.frame});
        return out;
    };
    std::vector<Shown> all = images(stage.binding->inputs, stage.data->inputs);
    const bool texels = std::any_of(samples.all.begin(), samples.all.end(), [](const Sample& s) { return !!s.texel; });
    const bool maps = std::any_of(all.begin(), all.end(), [](const Shown& s) { return !s.of_frame; });
    for (Shown& s : all) s.read_at = texels && s.of_frame != maps;
    // What is read comes first, light above all: it is what the samples gather.
    std::vector<Shown> sorted;
    for (const int rank : {0, 1, 2})
        for (const Shown& s : all)
            if ((s.read_at ? (s.slot.unit.rfind("W", 0) == 0 ? 0 : 1) : 2) == rank) sorted.push_back(s);
    if (stage.outputs)
        for (const Shown& s : images(stage.binding->outputs, *stage.outputs)) sorted.push_back(s);
    return sorted;
}

void figure(Page& page, const Image<std::uint32_t>& image, const std::string& caption, page::Overlay overlay) {
    page.figure(page.picture(image, caption), overlay);
}

// The texels around the pixel, one by one.
void figure_near(Page& page, const SlotPicture& picture, const Marks& marks, glm::ivec2 size) {
    const int side = std::min(near_texels, std::max(size.x, size.y));
    const glm::ivec2 first = marks.pixel - side / 2;
    const Scale scale{double(side) / near_px};
    page::Overlay overlay{{side, side}, {0, 0, side, side}, near_px, ""};
    overlay.marks = fmt::format("<g transform=\"translate({} {})\">{}{}</g>", -first.x, -first.y, marks.triangle,
                                pixel_mark(marks.pixel, {1 << 20, 1 << 20}, scale));
    figure(page, crop(picture.texels, first, {side, side}),
           fmt::format("{} x {} texels around {},{}", side, side, marks.pixel.x, marks.pixel.y), overlay);
}

// The region that samples take up, where that is a small part of the map.
void figure_of_region(Page& page, const SlotPicture& picture, const Shown& shown, const Marks& marks) {
    const std::optional<Extent> extent = extent_of(marks.samples, marks.projection);
    if (!extent) return;
    const glm::ivec2 size = layer_size(shown.slot, shown.array);
    const glm::dvec2 low = glm::clamp(extent->low, glm::dvec2(-16), glm::dvec2(size) + 16.0),
                     high = glm::clamp(extent->high, glm::dvec2(-16), glm::dvec2(size) + 16.0);
    const double side = std::max({16.0, std::ceil(1.3 * (high.x - low.x)), std::ceil(1.3 * (high.y - low.y))});
    if (side > 0.6 * std::max(size.x, size.y)) return;
    const glm::ivec2 first(glm::floor((low + high) / 2.0 - side / 2));
    const int texels = int(side);
    const Scale scale{side / map_px};
    page::Overlay overlay{{side, side}, {0, 0, side, side}, map_px, ""};
    overlay.marks = fmt::format("<g transform=\"translate({} {})\">{}{}</g>", -first.x, -first.y,
                                sample_marks(marks.samples, marks.key, scale),
                                marks.projection ? point_mark(*marks.projection, scale) : "");
    const Image<std::uint32_t> part = crop(picture.texels, first, {texels, texels});
    figure(page, reduced(part, reduction(part, kept_texels)),
           fmt::format("{}: {} x {} texels from {},{}", shown.slot.name, texels, texels, first.x, first.y), overlay);
}

std::string caption_of(const SlotPicture& picture, int by) {
    return fmt::format("{}. {} x {}{}; {}", picture.name, picture.texels.width, picture.texels.height,
                       by > 1 ? fmt::format(", shown at 1/{}", by) : "", picture.mapping);
}

DrawnPicture drawn_map(const SlotPicture& picture, const Shown& shown, const Marks& marks) {
    const glm::dvec2 size = layer_size(shown.slot, shown.array);
    // What lies outside is seen as far as a tenth of the map, which itself is always as large.
    glm::dvec2 low(0), high = size;
    const bool many = marks.samples.all.size() > most_marks;
    if (const auto extent = extent_of(marks.samples, marks.projection); extent && shown.read_at && !many) {
        low = glm::max(glm::min(low, extent->low - 0.02 * size), -0.1 * size);
        high = glm::min(glm::max(high, extent->high + 0.02 * size), 1.1 * size);
    }
    const Scale scale{std::max(size.x, size.y) / map_px};
    page::Overlay overlay{size, {low.x, low.y, high.x - low.x, high.y - low.y},
                          int(std::round((high.x - low.x) / scale.texels_a_px)), ""};
    if (shown.read_at && !many) overlay.marks += sample_marks(marks.samples, marks.key, scale);
    if (!shown.of_frame && marks.projection) overlay.marks += point_mark(*marks.projection, scale);
    if (shown.of_frame) overlay.marks += marks.triangle + pixel_mark(marks.pixel, glm::ivec2(size), scale);
    const int by = reduction(picture.texels, kept_texels);
    return {reduced(picture.texels, by), caption_of(picture, by), overlay};
}

void figure_of_map(Page& page, const Shown& shown, const Marks& marks) {
    const SlotPicture picture = slot_picture(shown.slot, shown.array, shown.layer);
    const DrawnPicture drawn = drawn_map(picture, shown, marks);
    figure(page, drawn.texels, drawn.caption, drawn.overlay);
    if (shown.read_at && marks.samples.all.size() <= most_marks) figure_of_region(page, picture, shown, marks);
}

void figure_of_frame(Page& page, const Shown& shown, const Marks& marks) {
    const SlotPicture picture = slot_picture(shown.slot, shown.array, shown.layer);
    const glm::ivec2 size = layer_size(shown.slot, shown.array);
    const int most = std::max(size.x, size.y), by = reduction(picture.texels, kept_texels);
    page::Overlay overlay{size, {0, 0, size.x, size.y}, frame_px * size.x / most, ""};
    overlay.marks = marks.triangle + pixel_mark(marks.pixel, size, {double(most) / frame_px});
    figure(page, reduced(picture.texels, by), caption_of(picture, by), overlay);
    figure_near(page, picture, marks, size);
}

// Where marks would hide each other: what each texel brought.
void figure_of_contributions(Page& page, const Samples& samples, glm::ivec2 size,
                             std::optional<glm::dvec2> projection) {
    Image4 image(size.x, size.y, glm::vec4(0));
    for (const Sample& s : samples.all) {
        if (!s.texel || !(s.texel->x >= 0 && s.texel->y >= 0 && s.texel->x < size.x && s.texel->y < size.y)) continue;
        glm::vec4& texel = image(int(s.texel->x), int(s.texel->y));
        for (std::size_t c = 0; c < std::min<std::size_t>(s.contribution.size(), 3); ++c)
            texel[int(c)] += float(s.contribution[c]);
    }
    Bundle made;
    add(made, "contribution", image);
    const Slot slot{.name = "contribution", .unit = "W/m2", .meaning = "of each texel, before the sum is scaled"};
    const Shown shown{slot, made.arrays[0], 0, false, false};
    figure_of_map(page, shown, {samples, "", {0, 0}, projection, ""});
}

void pictures(Page& page, const ExplainedStage& stage, const std::vector<TapValue>& values, const Samples& samples,
              const std::string& key) {
    Marks marks{samples, key, stage.pixel, projection_of(values)};
    if (const TapValue* triangle = single(values, "triangle"); triangle && stage.binding->raster)
        marks.triangle = triangle_mark(*stage.data, int(triangle->value[0]));
    const std::vector<Shown> all = shown_of(stage, samples);
    if (samples.all.size() > most_marks)
        for (const Shown& s : all)
            if (s.read_at) {
                figure_of_contributions(page, samples, layer_size(s.slot, s.array), marks.projection);
                break;
            }
    for (const Shown& s : all) {
        if (s.of_frame && !s.read_at)
            figure_of_frame(page, s, marks);
        else
            figure_of_map(page, s, marks);
    }
    std::string buffers;
    for (const Slot& slot : stage.binding->inputs)
        if (const Array* array = find(stage.data->inputs, slot.name); array && slot.kind == SlotKind::buffer)
            buffers += fmt::format("<li>{}</li>\n", escaped(buffer_text(slot, *array)));
    if (!buffers.empty()) page.raw("<ul class=\"note\">\n" + buffers + "</ul>\n");
}

// ---- Numbers ------------------------------------------------------------------------------------------------------

std::string side_text(const std::optional<std::vector<double>>& value) { return value ? exact_text(*value) : "-"; }

std::string values_markup(const parity::SideBySide& values, std::size_t first, std::size_t last, bool device) {
    std::string out = "<div class=\"scroll\"><table>\n";
    if (device) out += "<thead><tr><td>name</td><td>ours</td><td>the device's</td><td>equation</td></tr></thead>\n";
    for (std::size_t i = first; i < last; ++i) {
        const TwoValues& v = values.lines[i];
        out += fmt::format("<tr><td>{}</td><td>{}</td>", escaped(v.name), side_text(v.ours));
        if (device)
            out += fmt::format("<td>{}{}</td>", v.compared ? side_text(v.theirs) : "",
                               values.parts_at == i       ? " " + page::badge("here they part", "bad")
                               : v.compared && !v.same ? " " + page::badge("differs", "doubt")
                                                       : "");
        out += fmt::format("<td>{}</td></tr>\n", escaped(v.equation));
    }
    return out + "</table></div>\n";
}

std::string summary_of(const Sample& s) {
    std::string text = fmt::format("sample {}", s.number);
    if (s.path) text += fmt::format(", path {}, step {}", *s.path, *s.step);
    if (s.texel) text += fmt::format(", texel {:g},{:g}", s.texel->x, s.texel->y);
    if (!s.inside) text += ", outside";
    if (s.hidden()) text += ", hidden";
    if (!s.contribution.empty()) {
        text += ":";
        for (const double c : s.contribution) text += fmt::format(" {:.5g}", c);
    }
    return text;
}

// The samples that a page lists: all, or those that bring most; these first.
std::vector<std::size_t> listed(const Samples& samples) {
    std::vector<std::size_t> rows = by_contribution(samples, 0, samples.all.size());
    if (rows.size() > most_rows) rows.resize(most_rows);
    return rows;
}

std::string left_out(const Samples& samples) {
    return samples.all.size() <= most_rows
               ? ""
               : fmt::format("The {} of {} samples that bring most; --json lists all.", most_rows, samples.all.size());
}

// Above the table: in which order, what is left out, and how many samples bring nothing.
std::string samples_caption(const Samples& samples) {
    std::string text = left_out(samples);
    if (const std::string nothing = nothing_brought(samples); !nothing.empty())
        text += (text.empty() ? "Largest first. " : " Largest first. ") + nothing + ".";
    return text;
}

void table_of_samples(Page& page, const std::vector<TapValue>& values, const Samples& samples,
                      const std::vector<std::size_t>& rows, const std::string& key) {
    if (samples.all.empty()) return;
    const SampleTable table = sample_table(samples, values, rows);
    const double total = samples.total();
    std::vector<std::vector<Cell>> cells(1);
    for (const std::string& head : table.head) {
        const auto tap = std::find_if(values.begin(), values.end(),
                                      [&](const TapValue& v) { return v.name == head && v.sample >= 0; });
        cells[0].push_back({head, true, -1, tap == values.end() ? "" : tap->equation});
    }
    if (total > 0) cells[0].push_back({"share, %", true, -1, "of all contributions, by luminance"});
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const Sample& s = samples.all[rows[i]];
        cells.emplace_back();
        for (std::size_t c = 0; c < table.head.size(); ++c) {
            cells.back().push_back({table.rows[i][c], true});
            if (table.head[c] == "contribution") cells.back().back().order = s.brought();
        }
        if (total > 0) cells.back().push_back({fmt::format("{:.3g}", 100 * s.brought() / total), true});
        cells.back().front().key = fmt::format("{}{}", key, rows[i]);
    }
    page.table(cells, samples_caption(samples));
    if (!samples.gathers) return;
    std::string sum;
    for (const double c : samples.together) sum += fmt::format(" {:.9g}", c);
    page.raw(fmt::format("<p>All contributions, weight visibility flux form, added up in double precision:{}.{}</p>\n",
                         sum, samples.all.back().sum.empty() ? ""
                                  : " The kernel's own sum: " + exact_text(samples.all.back().sum) + "."));
}

// Every value; those of a sample are opened by a click. Samples that follow one another are listed as they bring; beside a
// device's values as the kernel has them, so that the first that parts comes first.
void list_of_values(Page& page, const ExplainedStage& stage, const Samples& samples,
                    const std::vector<std::size_t>& rows, const std::string& key) {
    const std::set<std::size_t> wanted(rows.begin(), rows.end());
    const bool device = !stage.device.empty(), ordered = !device && !nothing_brought(samples).empty();
    page.raw(ordered ? "<h3>Every value, samples by what they bring</h3>\n" : "<h3>Every value, in the kernel's order</h3>\n");
    const std::vector<TwoValues>& lines = stage.values.lines;
    for (std::size_t i = 0, first = 0; i < lines.size();) {
        if (lines[i].sample < 0) {
            std::size_t end = i;
            while (end < lines.size() && lines[end].sample < 0) ++end;
            page.raw(values_markup(stage.values, i, end, device));
            i = end;
            continue;
        }
        const std::size_t behind = end_of_run(samples, first);
        std::vector<std::size_t> order = by_contribution(samples, first, behind);
        if (!ordered) std::sort(order.begin(), order.end());
        for (const std::size_t sample : order) {
            const Sample& s = samples.all[sample];
            const bool parts = stage.values.parts_at && *stage.values.parts_at >= s.first && *stage.values.parts_at < s.last;
            if (wanted.count(sample) || parts)
                page.raw(fmt::format("<details data-key=\"{}{}\"{}><summary>{}</summary>{}</details>\n", escaped(key),
                                     sample, parts ? " open" : "", escaped(summary_of(s)),
                                     values_markup(stage.values, s.first, s.last, device)));
        }
        i = samples.all[behind - 1].last, first = behind;
    }
    if (samples.all.size() > rows.size()) page.raw(fmt::format("<p class=\"note\">{}</p>\n", left_out(samples)));
}

}  // namespace

SampleShape sample_shape(const StageBinding* binding, const StageData* data, glm::ivec2 pixel) {
    SampleShape shape;
    if (!binding || !data) return shape;
    shape.pixel = pixel;
    for (const UniformMember& m : binding->uniforms) {
        if (m.type != "int") continue;
        const int value = int(uniform_value(*binding, *data, m.name).at(0));
        if (m.name == "steps") shape.steps = value;
        if (m.name == "radius_x") shape.radius.x = value;
        if (m.name == "radius_y") shape.radius.y = value;
    }
    for (const Slot& slot : binding->inputs)
        if (const Array* array = find(data->inputs, slot.name);
            array && !slot.frame && layers_of(slot, *array) == 1 && shape.map_width == 0)
            shape.map_width = layer_size(slot, *array).x;
    return shape;
}

std::vector<DrawnPicture> sample_plot(const StageBinding& binding, const StageData& data, glm::ivec2 pixel,
                                      const std::vector<TapValue>& values) {
    const Samples samples = samples_of(values, sample_shape(&binding, &data, pixel));
    if (samples.all.empty() || samples.all.size() > most_marks) return {};
    ExplainedStage stage;
    stage.pixel = pixel, stage.binding = &binding, stage.data = &data;
    const std::vector<Shown> all = shown_of(stage, samples);
    if (all.empty() || !all.front().read_at) return {};
    return {drawn_map(slot_picture(all.front().slot, all.front().array, all.front().layer), all.front(),
                      {samples, "", pixel, projection_of(values)})};
}

ExplainPage::ExplainPage(const std::string& title) : page_(title) {}

void ExplainPage::picture(const Image4& display, glm::ivec2 pixel) {
    Bundle made;
    plumb::add(made, "display", display);
    const Slot slot{.name = "display", .meaning = "the picture that this leads to"};
    const Samples none;
    figure_of_frame(page_, {slot, made.arrays[0], 0, true}, {none, "", pixel, {}, ""});
}

void ExplainPage::add(const ExplainedStage& stage) {
    const std::vector<TapValue> values = our_values(stage.values);
    const Samples samples = samples_of(values, sample_shape(stage.binding, stage.data, stage.pixel));
    const std::string key = fmt::format("{}.", stages_++);
    const std::string where = stage.item && stage.pixel.y == 0 ? fmt::format(", item {}", stage.pixel.x) : fmt::format(" at {},{}", stage.pixel.x, stage.pixel.y);
    page_.heading(stage.label + where, "stage" + key);
    page_.raw(fmt::format("<p class=\"note\">{}</p>\n", escaped(stage.source)));
    if (!stage.device.empty()) page_.paragraph("On " + stage.device + ".");
    for (const std::string& note : stage.notes) page_.paragraph(note);
    page_.raw("<div class=\"explained\"><div>\n");
    if (stage.binding) pictures(page_, stage, values, samples, key);
    for (const frame::ItemPicture& p : stage.pictures) figure_of_map(page_, {p.slot, p.array, 0, false, false}, {no_samples, "", {0, 0}, {}, ""});
    page_.raw("</div><div class=\"numbers\">\n");
    const std::vector<std::size_t> rows = listed(samples);
    table_of_samples(page_, values, samples, rows, key);
    list_of_values(page_, stage, samples, rows, key);
    page_.raw("</div></div>\n");
}

}  // namespace plumb::cli
