#include "io/manifest.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"
#include "io/document.h"
#include "io/dump_encoding.h"
#include "io/file.h"
#include "io/filling.h"

namespace plumb::io {
namespace {

using Kind = DocumentValue::Kind;

constexpr int max_side = 32767;
constexpr int max_rows = 1 << 20;  // of an input: layers lie one below the other
constexpr std::size_t max_manifest_bytes = std::size_t(1) << 24;
constexpr std::size_t max_numbers = 16;  // of a uniform or a parameter: a matrix

class ManifestReader {
  public:
    explicit ManifestReader(const std::filesystem::path& file) : path_(file.string()) { manifest_.file = file; }

    Manifest read() {
        const DocumentValue root = parse_document(path_, read_text(path_, max_manifest_bytes));
        if (root.kind != Kind::table) throw InputError(shown(path_), "", "expected an object with the key \"stage\"");
        DocumentReader top(root, path_, "");
        top.allow({"device", "profile", "subpixel_bits", "max_ambiguous", "scene", "export", "stage"});
        manifest_.device = top.word("device", manifest_.device);
        manifest_.profile = top.filled("profile", manifest_.profile);
        manifest_.subpixel_bits = int(top.integer("subpixel_bits", 0, 1, 16));
        if (manifest_.subpixel_bits > 0 && manifest_.profile != "ideal")
            top.fail("subpixel_bits", fmt::format("the profile {} states its own; expected none, or the profile ideal",
                                                  printable(manifest_.profile)));
        manifest_.max_ambiguous = top.number("max_ambiguous", manifest_.max_ambiguous, 0, 1);
        if (top.has("scene")) manifest_.scene = file_of(top.filled("scene", ""));
        read_export(top);
        const auto stages = top.tables("stage");
        if (stages.empty()) throw InputError(shown(path_), "", "names no stage; expected at least one, [[stage]]");
        for (const DocumentValue* stage : stages) read_stage(*stage);
        return std::move(manifest_);
    }

  private:
    std::filesystem::path file_of(const std::string& name) const { return beside(path_, name); }

    static bool is_hash(const DocumentValue& value) {
        return value.kind == Kind::text && value.text.size() == 16 &&
               value.text.find_first_not_of("0123456789abcdef") == std::string::npos;
    }

    // Names of files are relative and lead to no folder above: what is listed may be removed by another export.
    void read_export(DocumentReader& top) {
        const DocumentValue* table = top.table("export");
        if (!table) return;
        DocumentReader exported(*table, path_, "export");
        exported.allow({"id", "files"});
        const DocumentValue* id = exported.find("id");
        if (!id || !is_hash(*id)) exported.fail("id", "expected 16 hexadecimal digits");
        manifest_.exported.id = id->text;
        const DocumentValue* files = exported.table("files");
        if (!files) return;
        DocumentReader names(*files, path_, "files of export");
        for (const auto& [name, hash] : files->table) {
            const std::filesystem::path path(name);
            const bool inside = path.is_relative() && path.lexically_normal() == path && *path.begin() != "..";
            if (name.empty() || !inside) names.fail(name, "expected the name of a file in the folder of the manifest");
            if (!is_hash(hash)) names.fail(name, "expected a hash of 16 hexadecimal digits");
            manifest_.exported.files.emplace(name, hash.text);
        }
    }

    void read_stage(const DocumentValue& table) {
        const std::string number = fmt::format("stage {}", manifest_.stages.size() + 1);
        DocumentReader reader(table, path_, number);
        ManifestStage stage;
        stage.stage = reader.filled("stage", "");
        const std::string name = stage.stage.empty() ? number : fmt::format("{} ({})", number, printable(stage.stage));
        reader.rename(name);
        reader.allow({"stage", "label", "form", "light", "face", "size", "block", "params", "uniforms", "input",
                      "output", "choices", "coverage"});
        if (stage.stage.empty())
            reader.fail("stage", "is missing; expected a stage's name, as `plumb stages` lists them");
        stage.place = fmt::format("{}: {}", shown(path_), name);
        stage.label = reader.word("label", "");
        stage.form = reader.word("form", "");
        stage.light = reader.word("light", "");
        stage.face = reader.word("face", "");
        constexpr std::array<std::string_view, 6> faces = {"px", "nx", "py", "ny", "pz", "nz"};
        if (!stage.face.empty() && std::find(faces.begin(), faces.end(), stage.face) == faces.end())
            reader.fail("face", "expected px, nx, py, ny, pz or nz");
        if (reader.has("block")) stage.block = file_of(reader.filled("block", ""));
        read_size(reader, stage);
        read_params(reader, stage);
        read_uniforms(reader, stage);
        // Outputs first: their sizes may be the stage's.
        read_dumps(reader, "output", name, stage, stage.outputs);
        if (stage.outputs.empty()) reader.fail("output", "expected at least one output");
        read_dumps(reader, "input", name, stage, stage.inputs);
        if (const DocumentValue* choices = reader.table("choices"))
            stage.choices = read_spec(*choices, "choices of " + name, stage, false);
        if (const DocumentValue* coverage = reader.table("coverage"))
            stage.coverage.dump = read_spec(*coverage, "coverage of " + name, stage, false, &stage.coverage);
        manifest_.stages.push_back(std::move(stage));
    }

    void read_size(DocumentReader& reader, ManifestStage& stage) {
        const DocumentValue* size = reader.find("size");
        if (!size) return;
        const auto is_side = [](const DocumentValue& v) {
            return v.kind == Kind::number && v.is_integer && v.integer >= 1 && v.integer <= max_side;
        };
        if (size->kind != Kind::list || size->list.size() != 2 ||
            !std::all_of(size->list.begin(), size->list.end(), is_side))
            reader.fail("size", fmt::format("expected [width, height], each 1 to {}", max_side));
        stage.width = int(size->list[0].integer), stage.height = int(size->list[1].integer);
    }

    // A number, a word or a flag as a scene file writes it.
    static std::string word_of(const DocumentValue& value) {
        if (value.kind == Kind::text) return value.text;
        if (value.kind == Kind::flag) return value.flag ? "true" : "false";
        return value.is_integer ? fmt::format("{}", value.integer) : fmt::format("{}", value.number);
    }

    void read_params(DocumentReader& reader, ManifestStage& stage) {
        const DocumentValue* table = reader.table("params");
        if (!table) return;
        DocumentReader params(*table, path_, "params of " + reader.name());
        for (const auto& [key, value] : table->table) {
            const std::vector<DocumentValue> alone = {value};
            const auto& values = value.kind == Kind::list ? value.list : alone;
            if (values.empty() || values.size() > max_numbers)
                params.fail(key, fmt::format("expected 1 to {} values", max_numbers));
            for (const DocumentValue& v : values) {
                if (v.kind != Kind::number && v.kind != Kind::text && v.kind != Kind::flag)
                    params.fail(key, "expected a number, a string, true, false or a list of them");
                if (v.kind == Kind::number && !std::isfinite(v.number)) params.fail(key, "expected finite numbers");
                stage.params[key].push_back(word_of(v));
            }
        }
    }

    void read_uniforms(DocumentReader& reader, ManifestStage& stage) {
        const DocumentValue* table = reader.table("uniforms");
        if (!table) return;
        DocumentReader uniforms(*table, path_, "uniforms of " + reader.name());
        const DocumentValue* file = uniforms.find("file");
        if (!file || file->kind != Kind::text) return read_members(uniforms, *table, "", stage);
        stage.uniforms_file = file_of(uniforms.filled("file", ""));
        if (table->table.size() > 1) uniforms.fail("file", "is the whole block; no member stands beside it");
    }

    // Members of a struct are tables within, or have a dot in their key.
    void read_members(DocumentReader& uniforms, const DocumentValue& table, const std::string& prefix,
                      ManifestStage& stage) {
        DocumentReader members(table, path_, uniforms.name());
        for (const auto& [key, value] : table.table) {
            const std::string name = prefix + key;
            if (value.kind == Kind::table) {
                read_members(uniforms, value, name + ".", stage);
                continue;
            }
            const std::vector<DocumentValue> alone = {value};
            const auto& values = value.kind == Kind::list ? value.list : alone;
            std::vector<double> numbers;
            for (const DocumentValue& v : values) {
                const bool is_number = (v.kind == Kind::number && std::isfinite(v.number)) || v.kind == Kind::flag;
                if (!is_number) members.fail(key, "expected a finite number, true, false or a list of them");
                numbers.push_back(v.kind == Kind::flag ? double(v.flag) : v.number);
            }
            if (numbers.empty() || numbers.size() > max_numbers)
                members.fail(key, fmt::format("expected 1 to {} numbers", max_numbers));
            if (!stage.uniforms.emplace(name, std::move(numbers)).second) members.fail(key, "is given twice");
        }
    }

    void read_dumps(DocumentReader& reader, const std::string& kind, const std::string& stage_name,
                    ManifestStage& stage, std::map<std::string, DumpSpec>& to) {
        const DocumentValue* table = reader.table(kind);
        if (!table) return;
        DocumentReader dumps(*table, path_, kind + " of " + stage_name);
        for (const auto& [key, value] : table->table) {
            if (key.empty() || value.kind != Kind::table)
                dumps.fail(key, "expected a table with the key \"file\": [stage." + kind + ".<name>]");
            to.emplace(key, read_spec(value, fmt::format("{}.{} of {}", kind, printable(key), stage_name), stage,
                                      kind == "output"));
        }
    }

    DumpSpec read_spec(const DocumentValue& table, const std::string& name, ManifestStage& stage, bool is_output,
                       CoverageSpec* coverage = nullptr) {
        DocumentReader reader(table, path_, name);
        std::vector<std::string> keys = {"file",     "vk_format", "width", "height",   "count",    "row_pitch", "offset",
                                         "trailing", "layer",     "channels", "encoding", "near_far", "flip_y"};
        if (coverage) keys.insert(keys.end(), {"above", "below"});
        if (is_output) keys.insert(keys.end(), {"expected", "filling"});
        reader.allow(keys);
        DumpSpec spec;
        spec.place = fmt::format("{}: {}", reader.place(), name);
        const std::string file = reader.filled("file", "");
        if (file.empty()) reader.fail("file", "is missing; expected the name of a file");
        spec.file = file_of(file);
        spec.vk_format = reader.filled("vk_format", "");
        if (const std::string prefix = "VK_FORMAT_"; spec.vk_format.compare(0, prefix.size(), prefix) == 0)
            spec.vk_format.erase(0, prefix.size());
        constexpr std::int64_t max = std::numeric_limits<std::int64_t>::max();
        spec.width = int(reader.integer("width", 0, 1, max_side));
        spec.height = int(reader.integer("height", 0, 1, is_output ? max_side : max_rows));
        spec.count = int(reader.integer("count", 0, 1, std::numeric_limits<int>::max()));
        spec.row_pitch = reader.integer("row_pitch", 0, 1, max);
        spec.offset = reader.integer("offset", 0, 0, max);
        spec.trailing = reader.flag("trailing", false);
        spec.layer = reader.word("layer", "");
        spec.channels = reader.filled("channels", "");
        spec.encoding = reader.filled("encoding", spec.encoding);
        spec.flip_y = reader.flag("flip_y", false);
        if (is_output) read_filling(reader, spec);
        read_planes(reader, spec);
        if (coverage) read_limits(reader, *coverage);
        complete_size(reader, spec, stage, is_output);
        if (const auto fault = fault_of(spec)) reader.fail(fault->key, fault->cause);
        return spec;
    }

    void read_filling(DocumentReader& reader, DumpSpec& spec) {
        if (reader.has("expected")) spec.expected = file_of(reader.filled("expected", ""));
        if (!reader.has("filling")) return;
        spec.filling = parse_filling(reader.filled("filling", ""));
        if (!spec.filling) reader.fail("filling", "expected ffe00001 to fffffffe, as `plumb export` writes it");
    }

    static void read_limits(DocumentReader& reader, CoverageSpec& coverage) {
        constexpr double largest = std::numeric_limits<double>::max();
        coverage.above = reader.number("above", coverage.above, -largest, largest);
        if (!reader.has("below")) return;
        coverage.below = reader.number("below", 0, -largest, largest);
        if (!reader.has("above")) coverage.above = -unbounded;
        if (!(coverage.above < coverage.below)) reader.fail("below", "expected more than above");
    }

    void read_planes(DocumentReader& reader, DumpSpec& spec) {
        const DocumentValue* planes = reader.find("near_far");
        if (!planes) return;
        const auto is_plane = [](const DocumentValue& v) {
            return v.kind == Kind::number || (v.kind == Kind::text && v.text == "inf");
        };
        if (planes->kind != Kind::list || !std::all_of(planes->list.begin(), planes->list.end(), is_plane))
            reader.fail("near_far", "expected [near, far]; far may be inf (\"inf\" in JSON)");
        for (const DocumentValue& v : planes->list)
            spec.near_far.push_back(v.kind == Kind::text ? unbounded : v.number);
        if (spec.near_far.empty()) reader.fail("near_far", "expected [near, far]");
    }

    // Outputs are of the stage's size, but for lists; raw images are where nothing else is said. The stage's own may be an output's.
    void complete_size(DocumentReader& reader, DumpSpec& spec, ManifestStage& stage, bool is_output) {
        const bool has_some = spec.width > 0 || spec.height > 0;
        if (has_some && (spec.width == 0 || spec.height == 0))
            reader.fail(spec.width ? "height" : "width", "is missing; both or neither");
        if (is_output && has_some && stage.width == 0) stage.width = spec.width, stage.height = spec.height;
        if (is_output && has_some && (stage.width != spec.width || stage.height != spec.height))
            reader.fail("width", fmt::format("{} x {}: the stage's outputs are {} x {}", spec.width, spec.height,
                                             stage.width, stage.height));
        if (!has_some && spec.count == 0 && (is_output || !spec.vk_format.empty()))
            spec.width = stage.width, spec.height = stage.height;
    }

    std::string path_;
    Manifest manifest_;
};

}  // namespace

Manifest read_manifest(const std::filesystem::path& file) { return ManifestReader(file).read(); }

}  // namespace plumb::io
