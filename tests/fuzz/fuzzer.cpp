// libFuzzer's entry points. `--format=obj` chooses the target; libFuzzer passes over what begins with two dashes.
#include <OpenImageIO/imageio.h>

#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "mutate.h"
#include "watch.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t limit);

namespace {

const plumb::fuzz::Format* format = nullptr;
std::size_t most = 0;

const plumb::fuzz::Format* format_named(int count, char** words) {
    constexpr std::string_view option = "--format=";
    for (int i = 1; i < count; ++i) {
        const std::string_view word = words[i];
        if (word.substr(0, option.size()) != option) continue;
        for (const plumb::fuzz::Format& known : plumb::fuzz::formats())
            if (word.substr(option.size()) == known.name) return &known;
    }
    std::fprintf(stderr, "plumb_fuzz: expected --format= and one of");
    for (const plumb::fuzz::Format& known : plumb::fuzz::formats()) std::fprintf(stderr, " %s", known.name);
    std::fprintf(stderr, "\n");
    std::exit(2);
}

void say_most() { std::fprintf(stderr, "peak of one input: %zu bytes\n", most); }

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* count, char*** words) {
    format = format_named(*count, *words);
    // One thread: what an input reaches does not depend on who is first.
    OIIO::attribute("threads", 1);
    OIIO::attribute("exr_threads", -1);
    plumb::fuzz::scratch_folder();
    std::atexit(say_most);
    // What libraries set up once is not a file's.
    const std::uint8_t nothing[1] = {};
    format->run(nothing, 0);
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const plumb::fuzz::Watched watched = plumb::fuzz::watch(*format, data, size);
    if (!watched.within) {
        std::fprintf(stderr, "memory: %zu bytes at once; a file of %zu bytes needs %zu\n", watched.peak, size, watched.need);
        std::abort();
    }
    most = watched.peak > most ? watched.peak : most;
    return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t limit, unsigned seed) {
    return plumb::fuzz::mutate(format->run, LLVMFuzzerMutate, data, size, limit, seed);
}
