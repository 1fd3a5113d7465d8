#include "tools/shared/reference_files.h"

#include "core/error.h"

namespace plumb::cli {

namespace {

std::uint64_t picture_bytes(glm::ivec2 size) {
    return 2 * sizeof(glm::vec4) * std::uint64_t(size.x) * std::uint64_t(size.y);
}

// Words of 64 bits as the bundle's words of 32, low half first.
void add_words(Bundle& bundle, const char* name, const std::vector<std::uint64_t>& values) {
    std::vector<std::uint32_t> words;
    for (std::uint64_t v : values) {
        words.push_back(std::uint32_t(v));
        words.push_back(std::uint32_t(v >> 32));
    }
    add(bundle, name, {std::int64_t(values.size()), 2}, words.data());
}
std::vector<std::uint64_t> read_words(const Bundle& bundle, const char* name, std::int64_t count) {
    const std::span<const std::uint32_t> words = elements<std::uint32_t>(bundle, name, {count, 2});
    std::vector<std::uint64_t> values;
    for (std::size_t i = 0; i < words.size(); i += 2) values.push_back(words[i] | std::uint64_t(words[i + 1]) << 32);
    return values;
}

Image4 read_image(const Bundle& bundle, const char* name, glm::ivec2 size) {
    require(at(bundle, name), DType::f32, {size.y, size.x, 4});
    return image4(at(bundle, name));
}

Bundle bundle_of(const reference::KeptEstimate& kept) {
    const reference::Estimate& e = kept.estimate;
    Bundle bundle;
    add_words(bundle, "counts", {std::uint64_t(e.samples), std::uint64_t(e.rounds), e.rays, e.nonfinite});
    const double numbers[] = {e.relative_error, kept.ms};
    add(bundle, "numbers", {2}, numbers);
    add(bundle, "mean", e.mean);
    add(bundle, "error", e.error);
    return bundle;
}

// Throws InputError where the bundle is not what bundle_of() makes.
reference::KeptEstimate kept_of(const Bundle& bundle, glm::ivec2 size) {
    const std::vector<std::uint64_t> counts = read_words(bundle, "counts", 4);
    const std::span<const double> numbers = elements<double>(bundle, "numbers", {2});
    reference::KeptEstimate kept;
    kept.estimate = {read_image(bundle, "mean", size), read_image(bundle, "error", size), int(counts[0]),
                     int(counts[1]), counts[2], std::size_t(counts[3]), numbers[0]};
    kept.ms = numbers[1];
    return kept;
}

}  // namespace

ReferenceFiles::ReferenceFiles(std::string folder, std::uint64_t max_bytes, std::uint64_t program)
    : files_(std::move(folder), "reference", {max_bytes, program, "traced"}), max_bytes_(max_bytes) {}

std::optional<reference::KeptEstimate> ReferenceFiles::find(std::uint64_t key, glm::ivec2 size) {
    const std::optional<Bundle> found = files_.find(key, picture_bytes(size));
    if (!found) return std::nullopt;
    try {
        return kept_of(*found, size);
    } catch (const InputError& e) {
        files_.note(files_.path_of(key) + ": " + e.what() + "; traced anew");
        return std::nullopt;
    }
}

void ReferenceFiles::keep(std::uint64_t key, const reference::KeptEstimate& kept) {
    if (picture_bytes({kept.estimate.mean.width, kept.estimate.mean.height}) > max_bytes_) return;
    files_.keep(key, bundle_of(kept), "the reference");
}

}  // namespace plumb::cli
