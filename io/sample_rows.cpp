#include "io/sample_rows.h"

#include <fmt/format.h>

#include "core/error.h"
#include "io/file.h"
#include "io/npy.h"

namespace plumb::io {

namespace {

constexpr std::int64_t most_rows = 65536;
constexpr double most_texels = 32767, most_weight = 1e9;

template <class T>
std::vector<double> widened(const Array& array) {
    std::vector<double> values;
    for (const T& v : elements<T>(array, array.shape)) values.push_back(double(v));
    return values;
}

// Numbers that numpy writes for a table of numbers.
std::vector<double> numbers_of(const Array& array) {
    if (array.dtype == DType::f64) return widened<double>(array);
    if (array.dtype == DType::f32) return widened<float>(array);
    if (array.dtype == DType::i32) return widened<std::int32_t>(array);
    throw InputError(fmt::format("holds {}: expected f32, f64 or i32", dtype_name(array.dtype)));
}

void check_row(std::size_t k, const glm::dvec3& row) {
    for (const double d : {row.x, row.y})
        if (!(__builtin_fabs(d) <= most_texels))
            throw InputError(fmt::format("row {}: {:g}: expected an offset of -{} to {} texels", k, d, most_texels,
                                         most_texels));
    if (!(row.z >= 0 && row.z <= most_weight))
        throw InputError(fmt::format("row {}: the weight is {:g}: expected 0 to {:g} texels", k, row.z, most_weight));
}

std::vector<glm::dvec3> rows_of(const Array& array) {
    const bool shaped = array.shape.size() == 2 && array.shape[1] == 3;
    if (!shaped || array.shape[0] < 1 || array.shape[0] > most_rows)
        throw InputError(fmt::format("is {}: expected [N, 3] with N from 1 to {}: dx, dy in texels, and the weight",
                                     shape_text(array.shape), most_rows));
    const std::vector<double> values = numbers_of(array);
    std::vector<glm::dvec3> rows(std::size_t(array.shape[0]));
    for (std::size_t k = 0; k < rows.size(); ++k) {
        rows[k] = {values[3 * k], values[3 * k + 1], values[3 * k + 2]};
        check_row(k, rows[k]);
    }
    return rows;
}

}  // namespace

SampleRowsPtr read_sample_rows(const std::string& name, const std::string& path, const std::string& place) {
    if (path.empty()) return nullptr;
    const Array array = [&] {
        try {
            return read_npy(path);
        } catch (const InputError& e) {
            // The place in the file comes first; who named it, last.
            throw InputError(fmt::format("{} ({} names it)", e.what(), place));
        }
    }();
    try {
        return std::make_shared<const SampleRows>(SampleRows{name, shown(path), rows_of(array)});
    } catch (const InputError& e) {
        throw InputError(fmt::format("{}: {} ({} names it)", shown(path), e.what(), place));
    }
}

}  // namespace plumb::io
