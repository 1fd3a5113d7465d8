#include "gi/probes/flat_clusters.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "core/error.h"

namespace plumb::probes {

namespace {

std::int32_t next_first(std::size_t n) {
    if (n > std::size_t(std::numeric_limits<std::int32_t>::max()))
        throw InputError("clusters: a list of more than 2^31 elements");
    return std::int32_t(n);
}

[[noreturn]] void refuse(const std::string& what) { throw InputError("clusters: " + what); }

// A list of firsts: ascending from 0 to `size`.
void check_firsts(const char* name, const std::vector<std::int32_t>& first, std::size_t clusters, std::size_t size) {
    if (first.size() != clusters + 1 || first.front() != 0 || std::size_t(first.back()) != size ||
        !std::is_sorted(first.begin(), first.end()))
        refuse(std::string(name) + " does not fit its list");
}

void check(const FlatClusters& f) {
    const std::size_t n = f.rank.size();
    check_firsts("first_receiver", f.first_receiver, n, f.receivers.size());
    check_firsts("first_probe", f.first_probe, n, f.probes.size());
    check_firsts("first_value", f.first_value, n, f.spectrum.size());
    std::size_t rows = 0;
    for (const std::int32_t r : f.rank) {
        if (r < 0 || r > f.singular_values) refuse("a rank is out of range");
        rows += std::size_t(r);
    }
    check_firsts("first_row", f.first_row, n, rows);
    if (f.box.size() != 6 * n || f.errors.size() != 2 * n) refuse("boxes or errors are not one a cluster");
    const auto receivers = std::int32_t(f.cluster_of.size());
    for (const std::int32_t r : f.receivers)
        if (r < 0 || r >= receivers) refuse("a receiver is out of range");
    if (f.u.size() != f.cluster_of.size() * std::size_t(f.singular_values)) refuse("u is not one row a receiver");
    for (const std::int32_t c : f.cluster_of)
        if (c < -1 || c >= std::int32_t(n)) refuse("cluster_of is out of range");
}

}  // namespace

FlatClusters flat(const Clusters& clusters) {
    FlatClusters f;
    f.singular_values = clusters.singular_values;
    // The largest lists do not grow: they would be held twice.
    std::size_t numbers = 0, values = 0;
    for (const Cluster& c : clusters.clusters) numbers += c.sigma_vt.size(), values += c.spectrum.size();
    f.sigma_vt.reserve(numbers), f.spectrum.reserve(values);
    for (const Cluster& c : clusters.clusters) {
        f.receivers.insert(f.receivers.end(), c.receivers.begin(), c.receivers.end());
        f.first_receiver.push_back(next_first(f.receivers.size()));
        f.probes.insert(f.probes.end(), c.probes.begin(), c.probes.end());
        f.first_probe.push_back(next_first(f.probes.size()));
        f.rank.push_back(c.rank);
        f.first_row.push_back(f.first_row.back() + c.rank);
        f.sigma_vt.insert(f.sigma_vt.end(), c.sigma_vt.begin(), c.sigma_vt.end());
        f.spectrum.insert(f.spectrum.end(), c.spectrum.begin(), c.spectrum.end());
        f.first_value.push_back(next_first(f.spectrum.size()));
        for (const glm::vec3& corner : {c.low, c.high})
            for (int axis = 0; axis < 3; ++axis) f.box.push_back(corner[axis]);
        f.errors.push_back(c.error_published), f.errors.push_back(c.error_frobenius);
    }
    f.cluster_of = clusters.cluster_of;
    f.u = clusters.u;
    return f;
}

Clusters clusters_of(const FlatClusters& f, int coefficients) {
    check(f);
    Clusters all;
    all.singular_values = f.singular_values, all.cluster_of = f.cluster_of, all.u = f.u;
    std::size_t at = 0;
    for (std::size_t k = 0; k < f.rank.size(); ++k) {
        const auto part = [&](const auto& list, const std::vector<std::int32_t>& first) {
            return std::vector(list.begin() + first[k], list.begin() + first[k + 1]);
        };
        Cluster c;
        c.receivers = part(f.receivers, f.first_receiver), c.probes = part(f.probes, f.first_probe);
        c.spectrum = part(f.spectrum, f.first_value);
        c.rank = f.rank[k];
        const std::size_t size = std::size_t(c.rank) * c.probes.size() * std::size_t(coefficients);
        if (at + size > f.sigma_vt.size() || std::size_t(c.rank) > c.spectrum.size())
            refuse("sigma_vt or spectrum is too short");
        c.sigma_vt.assign(f.sigma_vt.begin() + std::ptrdiff_t(at), f.sigma_vt.begin() + std::ptrdiff_t(at + size));
        at += size;
        c.singular_values.assign(c.spectrum.begin(), c.spectrum.begin() + c.rank);
        c.sum_of_all = std::accumulate(c.spectrum.begin(), c.spectrum.end(), 0.0);
        c.error_published = f.errors[2 * k], c.error_frobenius = f.errors[2 * k + 1];
        c.low = {f.box[6 * k], f.box[6 * k + 1], f.box[6 * k + 2]};
        c.high = {f.box[6 * k + 3], f.box[6 * k + 4], f.box[6 * k + 5]};
        all.clusters.push_back(std::move(c));
    }
    if (at != f.sigma_vt.size()) refuse("sigma_vt is too long");
    return all;
}

namespace {

// Calls each(name, list) for every list: a bundle is written and read by the same names.
template <class Flat, class Each>
void each_list(Flat& f, Each each) {
    each("first_receiver", f.first_receiver), each("receivers", f.receivers), each("first_probe", f.first_probe);
    each("probes", f.probes), each("rank", f.rank), each("first_row", f.first_row), each("sigma_vt", f.sigma_vt);
    each("first_value", f.first_value), each("spectrum", f.spectrum), each("box", f.box), each("errors", f.errors);
    each("cluster_of", f.cluster_of), each("u", f.u);
}

}  // namespace

Bundle lent(const FlatClusters& f) {
    Bundle b;
    lend(b, "singular_values", {1}, &f.singular_values);
    each_list(f, [&](const char* name, const auto& list) { lend(b, name, {std::int64_t(list.size())}, list.data()); });
    return b;
}

FlatClusters flat_clusters(const Bundle& bundle) {
    FlatClusters f;
    f.singular_values = elements<std::int32_t>(bundle, "singular_values", {1})[0];
    each_list(f, [&](const char* name, auto& list) {
        using T = typename std::decay_t<decltype(list)>::value_type;
        const auto values = elements<T>(bundle, name, {any_extent});
        list.assign(values.begin(), values.end());
    });
    return f;
}

}  // namespace plumb::probes
