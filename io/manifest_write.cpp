#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "io/filling.h"
#include "io/manifest.h"

namespace plumb::io {
namespace {

// A basic string of TOML 1.0.
std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        const unsigned char byte = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\')
            out += '\\', out += c;
        else if (byte < 32 || byte == 127)
            out += fmt::format("\\u{:04X}", byte);
        else
            out += c;
    }
    return out + "\"";
}

std::string key_text(const std::string& key) {
    const auto is_bare = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
    };
    return !key.empty() && std::all_of(key.begin(), key.end(), is_bare) ? key : quoted(key);
}

std::string number_text(double x) {
    if (std::isinf(x)) return x > 0 ? "inf" : "-inf";
    if (std::isnan(x)) return "nan";
    const std::string text = fmt::format("{}", x);
    // To TOML digits alone are an integer of 64 bits, which has no -0.
    const bool fits = text.find_first_of(".e") != text.npos || (std::fabs(x) < 1e15 && text != "-0");
    return fits ? text : text + ".0";
}

// Unquoted where it comes back as the same word.
std::string word_text(const std::string& word) {
    if (word == "true" || word == "false") return word;
    double x = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), x);
    const bool is_number = error == std::errc() && end == word.data() + word.size() && std::isfinite(x);
    return is_number && fmt::format("{}", x) == word && number_text(x) == word ? word : quoted(word);
}

template <class T, class Text>
std::string list_text(const std::vector<T>& values, Text text) {
    std::string out;
    for (const T& value : values) out += (out.empty() ? "" : ", ") + text(value);
    return values.size() == 1 ? out : "[" + out + "]";
}

class ManifestWriter {
  public:
    explicit ManifestWriter(const Manifest& manifest) : manifest_(manifest) {}

    std::string text() {
        text_line("device", manifest_.device, "");
        text_line("profile", manifest_.profile, "");
        number_line("subpixel_bits", manifest_.subpixel_bits);
        out_ += "max_ambiguous = " + number_text(manifest_.max_ambiguous) + "\n";
        if (!manifest_.scene.empty()) text_line("scene", name_of(manifest_.scene), "");
        write(manifest_.exported);
        for (const ManifestStage& stage : manifest_.stages) write(stage);
        return std::move(out_);
    }

  private:
    void text_line(const std::string& key, const std::string& value, const std::string& fallback) {
        if (value != fallback) out_ += key + " = " + quoted(value) + "\n";
    }
    void number_line(const std::string& key, std::int64_t value) {
        if (value != 0) out_ += fmt::format("{} = {}\n", key, value);
    }
    void flag_line(const std::string& key, bool value) {
        if (value) out_ += key + " = true\n";
    }

    void write(const ExportRecord& exported) {
        if (exported.id.empty()) return;
        out_ += "\n[export]\n";
        text_line("id", exported.id, "");
        if (!exported.files.empty()) out_ += "[export.files]\n";
        for (const auto& [name, hash] : exported.files) out_ += key_text(name) + " = " + quoted(hash) + "\n";
    }

    // Relative to the manifest's folder, if the file lies in it or both are relative.
    std::string name_of(const std::filesystem::path& file) const {
        const std::filesystem::path folder = manifest_.file.parent_path();
        if (folder.empty()) return file.string();
        if (folder.is_absolute() != file.is_absolute()) return std::filesystem::absolute(file).string();
        const std::filesystem::path relative = file.lexically_relative(folder);
        const bool is_inside = !relative.empty() && *relative.begin() != "..";
        return is_inside || !file.is_absolute() ? relative.string() : file.string();
    }

    void write(const ManifestStage& stage) {
        out_ += "\n[[stage]]\n";
        text_line("stage", stage.stage, "");
        text_line("label", stage.label, "");
        text_line("form", stage.form, "");
        text_line("light", stage.light, "");
        text_line("face", stage.face, "");
        if (stage.width > 0) out_ += fmt::format("size = [{}, {}]\n", stage.width, stage.height);
        if (!stage.block.empty()) text_line("block", name_of(stage.block), "");
        if (!stage.params.empty()) out_ += "[stage.params]\n";
        for (const auto& [key, words] : stage.params)
            out_ += key_text(key) + " = " + list_text(words, word_text) + "\n";
        if (!stage.uniforms.empty() || !stage.uniforms_file.empty()) out_ += "[stage.uniforms]\n";
        if (!stage.uniforms_file.empty()) text_line("file", name_of(stage.uniforms_file), "");
        for (const auto& [key, numbers] : stage.uniforms)
            out_ += key_text(key) + " = " + list_text(numbers, number_text) + "\n";
        for (const auto& [name, view] : stage.views) write(name, view);
        for (const auto& [name, spec] : stage.inputs) write("[stage.input." + key_text(name) + "]", spec);
        for (const auto& [name, spec] : stage.outputs) write("[stage.output." + key_text(name) + "]", spec);
        if (!stage.choices.file.empty()) write("[stage.choices]", stage.choices);
        if (!stage.coverage.dump.file.empty()) write(stage.coverage);
    }

    // Without `above` there is no lower limit beside `below`, and 0 alone.
    void write(const CoverageSpec& coverage) {
        write("[stage.coverage]", coverage.dump);
        const bool both = !std::isinf(coverage.below) && !std::isinf(coverage.above);
        if (both || (std::isinf(coverage.below) && coverage.above != 0))
            out_ += "above = " + number_text(coverage.above) + "\n";
        if (!std::isinf(coverage.below)) out_ += "below = " + number_text(coverage.below) + "\n";
    }

    void write(const std::string& header, const DumpSpec& spec) {
        out_ += header + "\n";
        text_line("file", name_of(spec.file), "");
        if (!spec.expected.empty()) text_line("expected", name_of(spec.expected), "");
        if (spec.filling) text_line("filling", filling_text(*spec.filling), "");
        text_line("vk_format", spec.vk_format, "");
        number_line("width", spec.width);
        number_line("height", spec.height);
        number_line("count", spec.count);
        number_line("row_pitch", spec.row_pitch);
        number_line("offset", spec.offset);
        flag_line("trailing", spec.trailing);
        text_line("layer", spec.layer, "");
        text_line("channels", spec.channels, "");
        text_line("encoding", spec.encoding, "plain");
        flag_line("flip_y", spec.flip_y);
        if (!spec.near_far.empty()) out_ += "near_far = " + list_text(spec.near_far, number_text) + "\n";
        write_forms(spec);
        // Tables within come last.
        const std::string within = header.substr(1, header.size() - 2);
        for (const DumpSpec& factor : spec.factors) write("[[" + within + ".factor]]", factor);
        for (const DumpSpec& w : spec.w) write("[" + within + ".w]", w);
    }

    void write(const std::string& name, const ViewSpec& view) {
        out_ += "[stage.view_proj." + key_text(name) + "]\n";
        out_ += "rows = " + list_text(std::vector<double>(view.view_proj.begin(), view.view_proj.end()), number_text) + "\n";
        if (view.below_zero) out_ += "clip_depth = [-1, 1]\n";
        flag_line("reversed_z", view.reversed_z);
        text_line("y", view.y_up ? "up" : "down", "down");
    }

    static std::string matrix_text(const MatrixRows& rows, const std::string& more = "") {
        return "{ rows = " + list_text(std::vector<double>(rows.begin(), rows.end()), number_text) + more + " }";
    }

    void write_forms(const DumpSpec& spec) {
        if (const auto& from = spec.from_depth) {
            out_ += std::string("from_depth = { ") + (from->forward ? "view_proj" : "inverse_view_proj") + " = " + matrix_text(from->matrix);
            if (from->below_zero) out_ += ", clip_depth = [-1, 1]";
            if (from->reversed_z) out_ += ", reversed_z = true";
            out_ += (from->y_up ? ", y = \"up\" }\n" : " }\n");
        }
        if (spec.matrix) {
            const std::string of = spec.matrix->of.empty() ? "" : ", of = " + quoted(spec.matrix->of);
            out_ += "matrix = " + matrix_text(spec.matrix->rows, of) + "\n";
        }
        if (!spec.scale.empty()) out_ += "scale = " + list_text(spec.scale, number_text) + "\n";
        if (!spec.clamp.empty()) out_ += "clamp = " + list_text(spec.clamp, number_text) + "\n";
        flag_line("normalized", spec.normalized);
        if (spec.along_normal != 0) out_ += "along_normal = " + number_text(spec.along_normal) + "\n";
        if (spec.radius != 1) out_ += "radius = " + number_text(spec.radius) + "\n";
        if (spec.of_map) text_line("unit", "map", "texels");
        text_line("y", spec.y_up ? "up" : "down", "down");
        text_line("beyond", spec.skips_beyond ? "skip" : "read", "read");
        if (spec.tile[0] > 0) out_ += fmt::format("tile = [{}, {}]\n", spec.tile[0], spec.tile[1]);
        if (const auto& s = spec.sampler) {
            text_line("filter", s->linear ? "linear" : "nearest", "");
            text_line("address", s->address == SamplerSpec::edge ? "edge" : s->address == SamplerSpec::wrap ? "wrap" : "border", "");
            if (s->colour != std::array<double, 4>{})
                out_ += "border = " + list_text(std::vector<double>(s->colour.begin(), s->colour.end()), number_text) + "\n";
        }
        if (spec.weight_scale != 1) out_ += "weight_scale = " + number_text(spec.weight_scale) + "\n";
    }

    const Manifest& manifest_;
    std::string out_;
};

}  // namespace

std::string name_in(const Manifest& manifest, const std::filesystem::path& file) {
    const std::filesystem::path folder = manifest.file.parent_path();
    const std::filesystem::path from = folder.empty() ? "." : folder;
    if (from.is_absolute() != file.is_absolute()) return "";
    const std::filesystem::path name = file.lexically_normal().lexically_relative(from.lexically_normal());
    return name.empty() || *name.begin() == ".." ? "" : name.string();
}

std::string manifest_text(const Manifest& manifest) { return ManifestWriter(manifest).text(); }

}  // namespace plumb::io
