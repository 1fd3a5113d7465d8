// Writes the layout of a twin as a header: layout <path> <header> <spirv>...
//
// <path>: of the twin from the project's root; of a raster stage without .vert and .frag, with the SPIR-V of both. The
// header holds a struct named after the path, with a TwinLayout (core/twin_layout.h) and a check of the C++ struct that
// stands for the uniform block.
//
// layout --unread <spirv>...: fails where a member of a uniform block is read by none of the shaders of its folder that
// have the block; a struct that is passed on whole counts as read. Files are named <folder>.<name>.<stage>.spv.
#include <algorithm>
#include <cstdio>
#include <set>
#include <sstream>

#include "tools/twins/spirv.h"

namespace {

using namespace plumb::spirv;

struct Member {
    std::string name, type;
    std::uint32_t offset;
    std::vector<std::uint32_t> path;  // indices from the block's own members
    bool operator==(const Member&) const = default;
};

std::string scalar_name(const Module& m, std::uint32_t type) {
    const Type& t = m.types.at(type);
    if (t.opcode == op_type_float) return "float";
    if (t.opcode == op_type_int) return t.words[1] ? "int" : "uint";
    if (t.opcode != op_type_vector) return "";
    const std::string of = scalar_name(m, t.words[0]);
    return (of == "float" ? "" : of.substr(0, 1)) + "vec" + std::to_string(t.words[1]);
}

std::uint32_t bytes_of(const std::string& type) {
    const std::size_t vec = type.find("vec");
    return 4 * (vec == std::string::npos ? 1 : std::uint32_t(type[vec + 3] - '0'));
}

// The members of a struct and of the structs in it.
void add_members(const Module& m, std::uint32_t type, const std::string& prefix, std::uint32_t base,
                 std::vector<std::uint32_t> path, std::vector<Member>& out) {
    const Type& t = m.types.at(type);
    for (std::uint32_t i = 0; i < t.words.size(); ++i) {
        const std::string name = prefix + m.member_names.at(type).at(i);
        const std::uint32_t at = base + m.member_decorations.at(type).at(i).at(offset);
        std::vector<std::uint32_t> here = path;
        here.push_back(i);
        if (m.types.at(t.words[i]).opcode == op_type_struct)
            add_members(m, t.words[i], name + ".", at, here, out);
        else
            out.push_back({name, scalar_name(m, t.words[i]), at, here});
    }
}

struct Block {
    std::string name;
    std::vector<Member> members;
    std::uint32_t bytes = 0;
};

// A block of nothing but a struct is that struct.
Block block_of(const Module& m, std::uint32_t type) {
    Block b;
    b.name = m.names.at(type);
    std::vector<std::uint32_t> path;
    const Type& t = m.types.at(type);
    if (t.words.size() == 1 && m.types.at(t.words[0]).opcode == op_type_struct) type = t.words[0], path = {0};
    add_members(m, type, "", 0, path, b.members);
    for (const Member& member : b.members) b.bytes = std::max(b.bytes, member.offset + bytes_of(member.type));
    b.bytes = (b.bytes + 15) / 16 * 16;
    return b;
}

// Which members of the block at `variable` are loaded, alone or with the struct that they are in.
std::set<std::string> members_read(const Module& m, std::uint32_t variable, const Block& b) {
    std::map<std::uint32_t, std::vector<std::uint32_t>> pointers{{variable, {}}};
    std::set<std::string> read;
    for (const Instruction& in : m.instructions) {
        if (in.opcode == op_access_chain && pointers.count(in.words[2])) {
            std::vector<std::uint32_t> path = pointers[in.words[2]];
            for (std::size_t k = 3; k < in.words.size() && m.constants.count(in.words[k]); ++k)
                path.push_back(m.constants.at(in.words[k]));
            pointers[in.words[1]] = path;
        } else if (in.opcode == op_load && pointers.count(in.words[2])) {
            const std::vector<std::uint32_t>& path = pointers[in.words[2]];
            for (const Member& member : b.members) {
                const std::size_t n = std::min(path.size(), member.path.size());
                if (std::equal(path.begin(), path.begin() + std::ptrdiff_t(n), member.path.begin())) read.insert(member.name);
            }
        }
    }
    return read;
}

struct Binding {
    std::string name, kind, element;
    std::uint32_t at;
    bool operator==(const Binding&) const = default;
};

// What lies in a buffer: the type of the elements of its array.
Binding buffer_of(const Module& m, std::uint32_t variable, std::uint32_t type) {
    const Type& t = m.types.at(type);
    const Type& array = m.types.at(t.words[0]);
    const std::map<std::uint32_t, std::uint32_t> none;
    const auto members = m.member_decorations.find(type);
    const bool read_only = m.decorations.count(variable) && m.decorations.at(variable).count(non_writable);
    const bool member_read_only = members != m.member_decorations.end() && members->second.count(0) &&
                                  members->second.at(0).count(non_writable);
    const bool is_array = array.opcode == op_type_runtime_array || array.opcode == op_type_array;
    return {m.member_names.at(type).at(0), read_only || member_read_only ? "buffer" : "storage_buffer",
            scalar_name(m, is_array ? array.words[0] : t.words[0]), m.decorations.at(variable).at(binding)};
}

struct Layout {
    Block block;
    std::set<std::string> read;
    std::map<std::pair<std::string, std::uint32_t>, Binding> bindings;  // targets apart
};

void add_variable(const Module& m, std::uint32_t id, std::uint32_t storage, std::uint32_t pointee, bool fragment,
                  Layout& out) {
    const auto found = m.decorations.find(id);
    const std::map<std::uint32_t, std::uint32_t> none;
    const auto& decorations = found == m.decorations.end() ? none : found->second;
    const Type& t = m.types.at(pointee);
    Binding b;
    if (storage == uniform && decorations.count(binding)) {
        const Block block = block_of(m, pointee);
        if (out.block.bytes && block.members != out.block.members)
            throw std::runtime_error("its shaders have different uniform blocks");
        out.block = block;
        out.read.merge(members_read(m, id, block));
        return;
    } else if (storage == storage_buffer) {
        b = buffer_of(m, id, pointee);
    } else if (storage == uniform_constant && t.opcode == op_type_sampled_image) {
        const bool array = m.types.at(t.words[0]).words[3];
        b = {m.names.at(id), array ? "sampled_array" : "sampled_image", "", decorations.at(binding)};
    } else if (storage == uniform_constant && t.opcode == op_type_image) {
        const std::uint32_t format = t.words[6];  // 1 Rgba32f, 3 R32f, 24 Rgba32i, 25 ... ; of the types, the sampled one
        const std::string of = scalar_name(m, t.words[0]);
        const bool one = format == 3 || format == 24 || format == 33;
        b = {m.names.at(id), "storage_image", one ? of : of == "float" ? "vec4" : of.substr(0, 1) + "vec4",
             decorations.at(binding)};
    } else if (storage == output && fragment && decorations.count(location)) {
        b = {m.names.at(id), "target", scalar_name(m, pointee), decorations.at(location)};
    } else {
        return;
    }
    const auto [there, is_new] = out.bindings.insert({{b.kind == "target" ? "target" : "", b.at}, b});
    auto named = [](const Binding& one) {
        return one.kind + " \"" + one.name + "\"" + (one.element.empty() ? "" : " of " + one.element);
    };
    if (!is_new && there->second != b)
        throw std::runtime_error("binding " + std::to_string(b.at) + " is " + named(there->second) +
                                 " in one shader and " + named(b) + " in another");
}

std::string identifier(std::string path) {
    for (char& c : path)
        if (c == '/' || c == '.') c = '_';
    return path;
}

std::string header_of(const std::string& path, bool raster, const Layout& l) {
    std::ostringstream h;
    const std::string name = identifier(path);
    h << "// The layout of " << path << ", read from its SPIR-V.\n#pragma once\n\n#include <cstddef>\n\n"
      << "#include \"core/twin_layout.h\"\n\nnamespace plumb::twins {\n\nstruct " << name << " {\n"
      << "    static constexpr TwinMember members[] = {";
    for (const Member& m : l.block.members)
        if (m.name.find("padding") == std::string::npos)
            h << "{\"" << m.name << "\", \"" << m.type << "\", " << m.offset << "}, ";
    h << "};\n    static constexpr TwinBinding bindings[] = {";
    for (const auto& [key, b] : l.bindings)
        h << "{\"" << b.name << "\", TwinKind::" << b.kind << ", " << b.at << ", \"" << b.element << "\"}, ";
    h << "};\n    static constexpr TwinLayout layout{\"" << path << "\", " << (raster ? "true" : "false") << ", members, "
      << l.block.bytes << ", bindings};\n\n    // Block: the struct that our kernel reads the block as.\n"
      << "    template <class Block>\n    static consteval bool fits() {\n"
      << "        static_assert(sizeof(Block) == " << l.block.bytes << ", \"" << path << ": size of " << l.block.name
      << "\");\n";
    for (const Member& m : l.block.members)
        if (m.name.find("padding") == std::string::npos)
            h << "        static_assert(offsetof(Block, " << m.name << ") == " << m.offset << ", \"" << path << ": "
              << l.block.name << "." << m.name << "\");\n";
    h << "        return true;\n    }\n};\n\n}  // namespace plumb::twins\n";
    return h.str();
}

void add_shader(const std::string& spirv, Layout& layout) {
    const Module m = read_module(spirv);
    const bool fragment = spirv.ends_with(".frag.spv");
    for (const Instruction& in : m.instructions)
        if (in.opcode == op_variable)
            add_variable(m, in.words[1], in.words[2], m.types.at(in.words[0]).words[1], fragment, layout);
}

// "gi.isr" of "<folders>/gi.isr.blur.comp.spv".
std::string folder_of(const std::string& path) {
    std::string name = path.substr(path.rfind('/') + 1);
    for (int part = 0; part < 3; ++part) name = name.substr(0, name.rfind('.'));
    return name;
}

void refuse_unread(int count, char** paths) {
    std::map<std::string, Layout> blocks;  // by folder and name
    for (int i = 0; i < count; ++i) {
        Layout layout;
        add_shader(paths[i], layout);
        Layout& all = blocks[folder_of(paths[i]) + " " + layout.block.name];
        all.block = layout.block;
        all.read.merge(layout.read);
    }
    for (const auto& [key, layout] : blocks)
        for (const Member& m : layout.block.members)
            if (!layout.read.count(m.name) && m.name.find("padding") == std::string::npos)
                throw std::runtime_error(key + "." + m.name + " is never read: remove it");
}

}  // namespace

int main(int argc, char** argv) try {
    if (argc > 2 && std::string(argv[1]) == "--unread") {
        refuse_unread(argc - 2, argv + 2);
        return 0;
    }
    if (argc < 4) throw std::runtime_error("usage: layout <path> <header> <spirv>...");
    const std::string path = argv[1];
    Layout layout;
    try {
        for (int i = 3; i < argc; ++i) add_shader(argv[i], layout);
    } catch (const std::exception& error) {
        throw std::runtime_error(path + ": " + error.what());
    }
    std::ofstream header(argv[2]);
    header << header_of(path, argc > 4, layout);
    header.close();
    if (!header) throw std::runtime_error(std::string(argv[2]) + ": could not be written");
    return 0;
} catch (const std::exception& error) {
    std::fprintf(stderr, "twin layout: %s\n", error.what());
    return 1;
}
