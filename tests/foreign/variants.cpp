#include "tests/foreign/variants.h"

#include <algorithm>

#include "io/document.h"
#include "io/file.h"
#include "tools/mutants/mutant.h"

namespace plumb::foreign {

namespace {

const std::string folder = PLUMB_SOURCE_DIR "/tests/foreign/";
constexpr std::size_t most_bytes = 1 << 20;
const std::vector<std::string> host_words = {"",          "last frame",  "linear",     "row-major", "rgb for bgr",
                                             "no border", "full floats", "half floats"};

Edit read_edit(io::DocumentReader& reader) {
    Edit e{reader.filled("find", ""), reader.word("replace", ""), reader.flag("all", false)};
    if (e.find.empty()) reader.fail("find", "expected text");
    return e;
}

Variant read_variant(const io::DocumentValue& table, const std::string& path, const std::string& kind) {
    io::DocumentReader reader(table, path, kind);
    Variant v;
    v.name = reader.filled("name", "");
    reader.rename(v.name);
    v.renderer = reader.filled("renderer", "");
    v.file = reader.word("file", "");
    v.host = reader.word("host", "");
    v.cause = reader.word("cause", "");
    v.wrong = reader.word("wrong", "");
    v.named = reader.word("named", "");
    v.place = reader.place();
    if (reader.has("find")) v.edits.push_back(read_edit(reader));
    for (const io::DocumentValue* one : reader.tables("edit")) {
        io::DocumentReader edit(*one, path, v.name);
        v.edits.push_back(read_edit(edit));
        edit.finish();
    }
    reader.finish();
    if (v.name.empty()) reader.fail("name", "is missing");
    if (v.renderer != "A" && v.renderer != "B" && v.renderer != "C") reader.fail("renderer", "expected A, B or C");
    if (std::find(host_words.begin(), host_words.end(), v.host) == host_words.end())
        reader.fail("host", "see renderers.h");
    if (v.file.empty() != v.edits.empty()) reader.fail("file", "stands with its edits, and not without");
    if (v.edits.empty() && v.host.empty()) reader.fail("edit", "expected an edit, or host");
    return v;
}

}  // namespace

std::vector<Variant> read_variants(const std::string& file, const std::string& kind) {
    const std::string path = folder + file;
    const io::DocumentValue document = io::parse_document(path, io::read_text(path, most_bytes));
    io::DocumentReader reader(document, path, "");
    std::vector<Variant> out;
    for (const io::DocumentValue* table : reader.tables(kind)) out.push_back(read_variant(*table, path, kind));
    reader.finish();
    return out;
}

std::string shader_text(const std::string& file, const Variant& variant) {
    std::string text = io::read_text(folder + file, most_bytes);
    if (variant.file != file) return text;
    for (const Edit& edit : variant.edits) {
        mutants::Mutant one;
        one.name = variant.name, one.place = variant.place, one.file = file;
        one.find = edit.find, one.replace = edit.replace, one.all = edit.all;
        text = mutants::edited(one, text, 1);
    }
    return text;
}

std::vector<unsigned> compile(const std::string& file, const Variant& variant) {
    static const mutants::TwinCompiler compiler(PLUMB_GLSLANG, PLUMB_SOURCE_DIR);
    return compiler.compile_text("tests/foreign/" + file, shader_text(file, variant), variant.name);
}

}  // namespace plumb::foreign
