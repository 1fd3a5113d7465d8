// The time and the memory to read a model: by our reader, or by the one that programs commonly use, tinyobjloader or
// tinygltf. One file by one reader a run, so that the peak of memory is its own; tools/compare-readers runs it.
#include <tiny_gltf.h>
#include <tiny_obj_loader.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <exception>
#include <fstream>
#include <string>

#include "core/error.h"
#include "io/file.h"
#include "io/gltf.h"
#include "io/obj.h"

namespace plumb::bench {
namespace {

// The most memory that this process has had, in bytes: VmHWM of Linux.
long peak_bytes() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.rfind("VmHWM:", 0) == 0) return 1024 * std::stol(line.substr(6));
    return 0;
}

std::size_t by_ours(const std::string& file) {
    if (io::extension_of(file) == "obj") return io::read_obj(file).mesh.triangles.size();
    std::size_t triangles = 0;
    for (const Mesh& mesh : io::read_gltf(file).meshes) triangles += mesh.triangles.size();
    return triangles;
}

std::size_t by_tiny(const std::string& file) {
    std::size_t triangles = 0;
    if (io::extension_of(file) == "obj") {
        tinyobj::ObjReaderConfig config;
        config.triangulate = true, config.vertex_color = false;
        tinyobj::ObjReader reader;
        if (!reader.ParseFromFile(file, config)) throw InputError("tinyobjloader: " + reader.Error());
        for (const tinyobj::shape_t& shape : reader.GetShapes()) triangles += shape.mesh.indices.size() / 3;
        return triangles;
    }
    tinygltf::TinyGLTF reader;
    tinygltf::Model model;
    std::string error, warning;
    const bool read = io::extension_of(file) == "glb" ? reader.LoadBinaryFromFile(&model, &error, &warning, file)
                                                      : reader.LoadASCIIFromFile(&model, &error, &warning, file);
    if (!read) throw InputError("tinygltf: " + error);
    for (const tinygltf::Mesh& mesh : model.meshes)
        for (const tinygltf::Primitive& p : mesh.primitives)
            if (p.indices >= 0) triangles += model.accessors[std::size_t(p.indices)].count / 3;
    return triangles;
}

int run(const std::string& file, const std::string& reader) {
    const long before = peak_bytes();
    const auto start = std::chrono::steady_clock::now();
    const std::size_t triangles = reader == "ours" ? by_ours(file) : by_tiny(file);
    const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    std::printf("{\"triangles\": %zu, \"ms\": %.3f, \"bytes\": %ld}\n", triangles, ms, peak_bytes() - before);
    return 0;
}

}  // namespace
}  // namespace plumb::bench

int main(int argc, char** argv) {
    CLI::App app("The time and the peak of memory to read a model, as JSON");
    std::string file, reader = "ours";
    app.add_option("file", file, "an .obj, .gltf or .glb")->required();
    app.add_option("--by", reader, "whose reader")->check(CLI::IsMember({"ours", "tiny"}));
    CLI11_PARSE(app, argc, argv);
    try {
        return plumb::bench::run(file, reader);
    } catch (const plumb::InputError& e) {
        std::fprintf(stderr, "plumb_bench_read: %s\n", e.what());
        return 2;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "plumb_bench_read: %s\n", e.what());
        return 3;
    }
}
