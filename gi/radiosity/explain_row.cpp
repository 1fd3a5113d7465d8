#include "gi/radiosity/explain_row.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "gi/radiosity/element_items.h"

namespace plumb::radiosity {
namespace {

using Colour = glm::dvec3;

std::vector<double> numbers(const Colour& c) { return {c.x, c.y, c.z}; }

// A texel of the hemicube's rows, and where it lies unfolded.
struct Place {
    int face = 0;
    glm::ivec2 at{0};
};
Place unfolded(int size, int row, int column) {
    const int half = size / 2, last = size - 1;
    if (row < size) return {0, {half + column, half + row}};
    const int face = face_of_row(size, row), down = (row - size) % half;  // 0: the row next to the top
    switch (face) {
        case 1: return {face, {half + last - column, half - 1 - down}};          // u: turned by 180 degrees
        case 2: return {face, {half + column, half + size + down}};              // -u
        case 3: return {face, {half - 1 - down, half + column}};                 // t: a quarter clockwise
        default: return {face, {half + size + down, half + last - column}};      // -t: a quarter counter-clockwise
    }
}

// Sums over texels.
struct TexelSums {
    std::array<double, 3> share{};  // front, back, nothing
    std::array<int, 3> count{};
    std::array<double, 5> face_share{};
    std::array<Colour, 5> face_brought{};
    Colour brought{0};
};

TexelSums draw(const Elements& e, const SeenItems& seen, int size, const std::vector<double>& weights, const Buffer<glm::vec4>& radiosity, RowPictures& out) {
    out.triangle = Image<std::int32_t>(2 * size, 2 * size, -1);
    for (Image4* image : {&out.weight, &out.radiosity, &out.brought}) *image = Image4(2 * size, 2 * size, glm::vec4(0));
    TexelSums sums;
    for (int row = 0; row < rows_of_hemicube(size); ++row)
        for (int x = 0; x < size; ++x) {
            const std::size_t at = std::size_t(row) * std::size_t(size) + std::size_t(x);
            const Place place = unfolded(size, row, x);
            const glm::vec4& s = seen.at.texels[at];
            const double weight = weights[at];
            Colour b(0);
            if (s.w > 0) {
                const glm::uvec3 of = e.of[std::size_t(seen.triangle[at])];
                b = (1.0 - double(s.x) - double(s.y)) * Colour(radiosity[of.x]) + double(s.x) * Colour(radiosity[of.y]) + double(s.y) * Colour(radiosity[of.z]);
            }
            const std::size_t kind = s.w > 0 ? 0 : s.w < 0 ? 1 : 2;
            sums.share[kind] += weight, ++sums.count[kind];
            sums.face_share[std::size_t(place.face)] += weight, sums.face_brought[std::size_t(place.face)] += weight * b, sums.brought += weight * b;
            out.triangle(place.at.x, place.at.y) = seen.triangle[at];
            out.weight(place.at.x, place.at.y) = glm::vec4(float(weight), s.w, 0, 0);
            out.radiosity(place.at.x, place.at.y) = glm::vec4(glm::vec3(b), 0), out.brought(place.at.x, place.at.y) = glm::vec4(glm::vec3(weight * b), 0);
        }
    return sums;
}

class Values {
  public:
    void add(const char* name, std::vector<double> value, const char* equation, int sample = -1) {
        all.push_back({name, sample, std::move(value), equation});
    }
    std::vector<TapValue> all;
};

// The row's elements, those that bring most first; and what all of them bring.
Colour add_elements(const FormFactors& factors, const Buffer<glm::vec4>& radiosity, int element, Values& values) {
    std::vector<float> row(std::size_t(factors.count), 0.0f);
    factors.add_row(element, row);
    Colour all(0);
    double sum = 0;
    for (std::size_t j = 0; j < row.size(); ++j) all += double(row[j]) * Colour(radiosity[j]), sum += double(row[j]);
    std::vector<int> order(row.size());
    std::iota(order.begin(), order.end(), 0);
    const auto brings = [&](int j) {
        const glm::vec4& b = radiosity[std::size_t(j)];
        return double(row[std::size_t(j)]) * (double(b.x) + double(b.y) + double(b.z));
    };
    const std::size_t listed = std::min<std::size_t>(order.size(), explained_elements);
    std::partial_sort(order.begin(), order.begin() + long(listed), order.end(), [&](int a, int b) { return brings(a) != brings(b) ? brings(a) > brings(b) : a < b; });
    Colour rest = all;
    for (std::size_t k = 0; k < listed && row[std::size_t(order[k])] > 0; ++k) {
        const int j = order[k];
        const Colour brought = double(row[std::size_t(j)]) * Colour(radiosity[std::size_t(j)]);
        rest -= brought;
        values.add("F", {double(row[std::size_t(j)])}, "form factor of the element that the sample is numbered by", j);
        values.add("B", numbers(Colour(radiosity[std::size_t(j)])), "W/m2, what leaves it", j);
        values.add("brings", numbers(brought), "F B, W/m2", j);
    }
    values.add("rest", numbers(rest), "W/m2, of all elements that are not listed");
    values.add("row_sum", {sum}, "sum F_ij of the packed row");
    return all;
}

}  // namespace

RowExplained explain_row(const Elements& e, const RowParams& params, const FormFactors& factors, const Buffer<glm::vec4>& own,
                         const Buffer<glm::vec4>& radiosity, int element) {
    const std::size_t i = std::size_t(element);
    RowExplained out;
    const SeenItems seen = ElementItems(e, params.size).seen(element, 1, {});
    const TexelSums sums = draw(e, seen, params.size, texel_weights(params.size, params.weights), radiosity, out.pictures);
    Values v;
    v.add("position", numbers(Colour(e.position[i])), "m");
    v.add("normal", numbers(Colour(e.normal[i])), "");
    v.add("eye", numbers(Colour(e.eye[i])), "m, where its hemicube stands");
    v.add("height", {double(e.eye[i].w)}, "m, off its surface");
    static constexpr const char* kinds[3][2] = {{"front", "texels that see a front, and their share"}, {"back", "a back: it sends nothing"}, {"escaped", "nothing"}};
    for (std::size_t k = 0; k < 3; ++k) v.add(kinds[k][0], {double(sums.count[k]), sums.share[k]}, kinds[k][1]);
    static constexpr const char* faces[5] = {"top", "side_u", "side_-u", "side_t", "side_-t"};
    for (std::size_t f = 0; f < 5; ++f)
        v.add(faces[f], {sums.face_share[f], sums.face_brought[f].x, sums.face_brought[f].y, sums.face_brought[f].z}, "share, and what it brings, W/m2");
    const Colour by_elements = add_elements(factors, radiosity, element, v), own_light(own[i]);
    v.add("H0", numbers(own_light), "W/m2, by the sky and small emitters");
    v.add("by_texels", numbers(own_light + sums.brought), "H0 + sum over texels of weight B, W/m2");
    v.add("irradiance", numbers(own_light + by_elements), "H0 + sum F_ij B_j, W/m2: radiosity.gather adds the same in floats");
    out.values = std::move(v.all);
    return out;
}

}  // namespace plumb::radiosity
