#include "io/manifest.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/glm.hpp>

#include "core/error.h"
#include "io/document.h"
#include "io/dump_encoding.h"
#include "io/file.h"
#include "io/filling.h"

namespace plumb::io {
namespace {

using Kind = DocumentValue::Kind;

constexpr int max_side = 32767;
constexpr double most_metres = 1e6;
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
        reader.allow({"stage", "label", "form", "light", "face", "size", "block", "params", "uniforms",
                      "light_view_proj", "view_proj", "input", "output", "choices", "coverage"});
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
        read_views(reader, stage);
        // Outputs first: their sizes may be the stage's.
        read_dumps(reader, "output", name, stage, stage.outputs);
        if (stage.outputs.empty()) reader.fail("output", "expected at least one output");
        read_dumps(reader, "input", name, stage, stage.inputs);
        if (const DocumentValue* choices = reader.table("choices"))
            stage.choices = read_spec(*choices, "choices of " + name, stage, Role::other);
        if (const DocumentValue* coverage = reader.table("coverage"))
            stage.coverage.dump = read_spec(*coverage, "coverage of " + name, stage, Role::other, &stage.coverage);
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

    // [stage.light_view_proj] is [stage.view_proj.map].
    void read_views(DocumentReader& reader, ManifestStage& stage) {
        if (const DocumentValue* table = reader.table("light_view_proj"))
            stage.views.emplace("map", read_view(*table, "light_view_proj of " + reader.name()));
        const DocumentValue* views = reader.table("view_proj");
        if (!views) return;
        DocumentReader named(*views, path_, "view_proj of " + reader.name());
        for (const auto& [key, value] : views->table) {
            if (key.empty() || value.kind != Kind::table)
                named.fail(key, "expected a table with rows or columns: [stage.view_proj.<struct of the block>]");
            if (!stage.views.emplace(key, read_view(value, fmt::format("view_proj.{} of {}", printable(key), reader.name()))).second)
                named.fail(key, "is given twice: light_view_proj is view_proj.map");
        }
    }

    ViewSpec read_view(const DocumentValue& table, const std::string& name) {
        DocumentReader reader(table, path_, name);
        reader.allow({"rows", "columns", "clip_depth", "reversed_z", "y"});
        ViewSpec view;
        view.place = fmt::format("{}: {}", reader.place(), name);
        view.view_proj = read_matrix(reader);
        view.below_zero = read_clip_depth(reader);
        view.reversed_z = reader.flag("reversed_z", false);
        view.y_up = one_of(reader, "y", {"down", "up"}) == "up";
        return view;
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
                                      kind == "output" ? Role::output : key == "pattern" ? Role::pattern : Role::input));
        }
    }

    // `other`: choices, coverage and factors.
    enum class Role { input, pattern, output, other };

    DumpSpec read_spec(const DocumentValue& table, const std::string& name, ManifestStage& stage, Role role,
                       CoverageSpec* coverage = nullptr) {
        const bool is_output = role == Role::output;
        DocumentReader reader(table, path_, name);
        std::vector<std::string> keys = {"file",     "vk_format", "width", "height",   "count",    "row_pitch", "offset",
                                         "trailing", "layer",     "channels", "encoding", "near_far", "flip_y"};
        if (coverage) keys.insert(keys.end(), {"above", "below"});
        if (is_output) keys.insert(keys.end(), {"expected", "filling", "scale", "factor", "clamp"});
        if (role == Role::input)
            keys.insert(keys.end(), {"from_depth", "matrix", "scale", "factor", "normalized", "w", "filter", "address", "border", "along_normal"});
        if (role == Role::pattern) keys.insert(keys.end(), {"radius", "unit", "y", "weight_scale", "tile", "beyond"});
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
        if (role == Role::input) read_forms(reader, spec);
        if (is_output) read_written(reader, spec);
        if (role == Role::pattern) read_pattern(reader, spec);
        if (const auto fault = fault_of(spec)) reader.fail(fault->key, fault->cause);
        return spec;
    }

    // What an input goes through once it is decoded.
    void read_forms(DocumentReader& reader, DumpSpec& spec) {
        if (const DocumentValue* table = reader.table("from_depth")) read_from_depth(*table, reader.name(), spec);
        if (const DocumentValue* table = reader.table("matrix")) {
            DocumentReader matrix(*table, path_, "matrix of " + reader.name());
            matrix.allow({"rows", "columns", "of"});
            spec.matrix.emplace();
            spec.matrix->rows = read_matrix(matrix);
            spec.matrix->of = one_of(matrix, "of", {"", "points", "normals", "directions"});
        }
        read_factors(reader, spec);
        spec.normalized = reader.flag("normalized", false);
        read_images(reader, "w", spec, spec.w);
        if (spec.w.size() > 1) reader.fail("w", "expected one image");
        read_sampler(reader, spec);
        spec.along_normal = reader.number("along_normal", 0, -most_metres, most_metres);
    }

    void read_factors(DocumentReader& reader, DumpSpec& spec) {
        spec.scale = read_numbers(reader, "scale");
        if (!spec.scale.empty() && spec.scale.size() != 1 && spec.scale.size() != 3)
            reader.fail("scale", "expected a number, or one for each of x, y, z");
        read_images(reader, "factor", spec, spec.factors);
    }

    // What a shader does with a result before it writes it.
    void read_written(DocumentReader& reader, DumpSpec& spec) {
        read_factors(reader, spec);
        spec.clamp = read_numbers(reader, "clamp");
        if (!spec.clamp.empty() && (spec.clamp.size() != 2 || !(spec.clamp[0] < spec.clamp[1])))
            reader.fail("clamp", "expected [lowest, highest]");
    }

    static void read_sampler(DocumentReader& reader, DumpSpec& spec) {
        if (!reader.has("filter") && !reader.has("address") && !reader.has("border")) return;
        SamplerSpec sampler;
        sampler.linear = one_of(reader, "filter", {"nearest", "linear"}) == "linear";
        const std::string address = one_of(reader, "address", {"border", "edge", "wrap"});
        sampler.address = address == "edge" ? SamplerSpec::edge : address == "wrap" ? SamplerSpec::wrap : SamplerSpec::border;
        const std::vector<double> colour = read_numbers(reader, "border");
        if (!colour.empty() && (colour.size() != 4 || sampler.address != SamplerSpec::border))
            reader.fail("border", "expected four numbers, beside address = \"border\"");
        std::copy(colour.begin(), colour.end(), sampler.colour.begin());
        spec.sampler = sampler;
    }

    static void read_pattern(DocumentReader& reader, DumpSpec& spec) {
        constexpr double largest = std::numeric_limits<double>::max();
        spec.radius = reader.number("radius", 1, std::numeric_limits<double>::min(), 32767);
        spec.weight_scale = reader.number("weight_scale", 1, -largest, largest);
        spec.of_map = one_of(reader, "unit", {"texels", "map"}) == "map";
        spec.y_up = one_of(reader, "y", {"down", "up"}) == "up";
        spec.skips_beyond = one_of(reader, "beyond", {"read", "skip"}) == "skip";
        const std::vector<double> tile = read_numbers(reader, "tile");
        const auto is_side = [](double v) { return v >= 1 && v <= 256 && v == std::floor(v); };
        if (!tile.empty() && (tile.size() != 2 || !std::all_of(tile.begin(), tile.end(), is_side)))
            reader.fail("tile", "expected [width, height] in pixels, each 1 to 256");
        for (std::size_t i = 0; i < tile.size(); ++i) spec.tile[i] = int(tile[i]);
    }

    // A file, a table as an input's, or a list of tables; images are as large as what they go with.
    void read_images(DocumentReader& reader, const std::string& key, const DumpSpec& spec, std::vector<DumpSpec>& to) {
        const DocumentValue* image = reader.find(key);
        if (!image) return;
        const std::vector<DocumentValue> alone = {*image};
        for (const DocumentValue& value : image->kind == Kind::list ? image->list : alone) {
            if (value.kind != Kind::table && value.kind != Kind::text)
                reader.fail(key, "expected the name of a file, or a table with the key \"file\", or a list of them");
            DocumentValue table = value;
            if (value.kind == Kind::text) {
                table = {}, table.kind = Kind::table, table.place = value.place;
                table.table.push_back({"file", value});
            }
            // Beside the size of the input no stage's is asked for.
            ManifestStage sized;
            sized.width = spec.width, sized.height = spec.height;
            to.push_back(read_spec(table, key + " of " + reader.name(), sized, Role::other));
        }
        if (to.empty()) reader.fail(key, "expected at least one");
    }

    void read_from_depth(const DocumentValue& table, const std::string& name, DumpSpec& spec) {
        DocumentReader reader(table, path_, "from_depth of " + name);
        reader.allow({"inverse_view_proj", "view_proj", "clip_depth", "reversed_z", "y"});
        FromDepth from;
        from.forward = reader.has("view_proj");
        const std::string key = from.forward ? "view_proj" : "inverse_view_proj";
        if (from.forward && reader.has("inverse_view_proj")) reader.fail(key, "expected it or inverse_view_proj, not both");
        const DocumentValue* matrix = reader.table(key);
        if (!matrix) reader.fail(key, "is missing; expected { rows = [16 numbers] }, or columns; or view_proj");
        DocumentReader inside(*matrix, path_, key + " of " + reader.name());
        inside.allow({"rows", "columns"});
        from.matrix = read_matrix(inside);
        const MatrixRows inverse = inverse_of(from.matrix);
        if (from.forward && !std::all_of(inverse.begin(), inverse.end(), [](double v) { return std::isfinite(v); }))
            reader.fail(key, "has no inverse");
        from.below_zero = read_clip_depth(reader);
        from.reversed_z = reader.flag("reversed_z", false);
        from.y_up = one_of(reader, "y", {"down", "up"}) == "up";
        spec.from_depth = from;
    }

    // Whether clip space reaches from -1 on.
    static bool read_clip_depth(DocumentReader& reader) {
        const std::vector<double> range = read_numbers(reader, "clip_depth");
        const bool below_zero = range == std::vector<double>{-1, 1};
        if (!range.empty() && !below_zero && range != std::vector<double>{0, 1})
            reader.fail("clip_depth", "expected [0, 1] or [-1, 1]");
        return below_zero;
    }

    // Of a word that has to be one of those; the first where it is not there.
    static std::string one_of(DocumentReader& reader, const std::string& key, const std::vector<std::string>& words) {
        const std::string word = reader.word(key, words[0]);
        const auto choice = std::find(words.begin(), words.end(), word);
        if (choice != words.end() && (!word.empty() || !reader.has(key))) return word;
        std::vector<std::string> named = words;
        std::erase(named, "");
        reader.fail(key, fmt::format("expected {}", fmt::join(named, ", ")));
    }

    // `rows` or `columns`: how the 16 numbers follow each other is said, never guessed.
    static MatrixRows read_matrix(DocumentReader& reader) {
        const bool by_rows = reader.has("rows");
        if (by_rows == reader.has("columns"))
            reader.fail("rows", "expected 16 numbers row by row as rows, or column by column as columns; one of both");
        const std::vector<double> numbers = read_numbers(reader, by_rows ? "rows" : "columns");
        if (numbers.size() != 16)
            reader.fail(by_rows ? "rows" : "columns", fmt::format("expected 16 numbers, {} given", numbers.size()));
        MatrixRows rows;
        for (std::size_t i = 0; i < 16; ++i) rows[i] = numbers[by_rows ? i : i % 4 * 4 + i / 4];
        return rows;
    }

    // A number, or a list of them that may have lists within: 16 numbers as four rows. Empty where the key is not there.
    static std::vector<double> read_numbers(DocumentReader& reader, const std::string& key) {
        std::vector<double> numbers;
        const std::function<void(const DocumentValue&)> add = [&](const DocumentValue& value) {
            if (value.kind == Kind::list)
                for (const DocumentValue& one : value.list) add(one);
            else if (value.kind == Kind::number && std::isfinite(value.number))
                numbers.push_back(value.number);
            else
                reader.fail(key, "expected finite numbers");
        };
        if (const DocumentValue* value = reader.find(key)) {
            add(*value);
            if (numbers.empty()) reader.fail(key, "expected numbers");
        }
        return numbers;
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

MatrixRows inverse_of(const MatrixRows& rows) {
    glm::dmat4 m;
    for (int i = 0; i < 16; ++i) m[i % 4][i / 4] = rows[std::size_t(i)];
    m = glm::inverse(m);
    MatrixRows inverse;
    for (int i = 0; i < 16; ++i) inverse[std::size_t(i)] = m[i % 4][i / 4];
    return inverse;
}

Manifest read_manifest(const std::filesystem::path& file) { return ManifestReader(file).read(); }

}  // namespace plumb::io
