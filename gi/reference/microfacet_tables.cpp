#include "gi/reference/microfacet_tables.h"

#include <algorithm>
#include <array>
#include <vector>

#include "core/host_math.h"
#include "core/parallel.h"

namespace plumb::reference {

namespace {

double root(double x) { return __builtin_sqrt(x); }

// Gauss and Legendre's rule on -1..1: zeros of P_n by Newton's method.
struct Rule {
    std::vector<double> x, weight;
};
Rule gauss_legendre(int n) {
    Rule rule;
    for (int i = 0; i < n; ++i) {
        double x = host::cos(host::pi * (i + 0.75) / (n + 0.5)), slope = 1;
        for (int step = 0; step < 8; ++step) {
            double p = x, before = 1;
            for (int k = 2; k <= n; ++k) {
                const double next = ((2 * k - 1) * x * p - (k - 1) * before) / k;
                before = p, p = next;
            }
            slope = n * (x * p - before) / (x * x - 1);
            x -= p / slope;
        }
        rule.x.push_back(x), rule.weight.push_back(2 / ((1 - x * x) * slope * slope));
    }
    return rule;
}
std::vector<double> cosines_of(int turns) {
    std::vector<double> cosines;
    for (int i = 0; i < turns; ++i) cosines.push_back(host::cos((i + 0.5) * host::pi / turns));
    return cosines;
}

// Directions o and i at angles theta_o and theta_i, azimuths phi apart: with X = |o + i|^2 = B + C cos phi and a = (1 - alpha^2)
// (cos theta_o + cos theta_i)^2 it is D = alpha^2/pi X^2/(X - a)^2, and X - a = k + C cos phi lies between k - C and k + C.
struct Ring {
    double a, k, c, s;  // s = sqrt(k^2 - C^2)
};
// Of the sines and cosines of (theta_o + theta_i)/2 and (theta_o - theta_i)/2, so that nothing cancels.
Ring ring_of(double sine_sum, double cosine_sum, double sine_difference, double cosine_difference, double alpha2) {
    const double p = cosine_sum * cosine_sum, q = cosine_difference * cosine_difference;
    const double least = 4 * p * (sine_difference * sine_difference + alpha2 * q);
    const double largest = 4 * q * (sine_sum * sine_sum + alpha2 * p);
    return {(1 - alpha2) * 4 * p * q, (largest + least) / 2, (largest - least) / 2, root(least * largest)};
}

// The integral of X^2/(X - a)^2 over phi, in closed form.
double closed(const Ring& r) { return 2 * host::pi * (1 + 2 * r.a / r.s + r.a * r.a * r.k / (r.s * r.s * r.s)); }

// The same of X^2/(X - a)^2 (1 - V.H)^5, where V.H = sqrt(X)/2. With tan((pi - phi)/2) = sqrt((k - C)/(k + C)) tan(t/2) the
// peak at phi = pi spreads: X - a = s^2/(k + C cos t), dphi/(X - a) = dt/s.
double of_schlick(const Ring& r, const std::vector<double>& cosines) {
    double sum = 0;
    for (const double c : cosines) {
        const double x = r.s * r.s / (r.k + r.c * c), whole = x + r.a, u = std::max(1 - root(whole) / 2, 0.0);
        sum += whole * whole / (x * r.s) * (u * u * u * u * u);
    }
    return sum * 2 * host::pi / double(cosines.size());
}

// Integrals over all directions i of D V cos theta_i, V the height-correlated visibility. Tangents of half the angle from
// theta_o, where D peaks and V, of a cosine below alpha, bends, or from the horizon, where V bends within alpha, are spaced
// as sinh.
class OverDirections {
  public:
    OverDirections(double cosine, double alpha, const Rule& rule, const std::vector<double>& cosines)
        : cosine_o_(cosine), sine_o_(root((1 - cosine) * (1 + cosine))), alpha2_(alpha * alpha),
          root_o_(root(alpha2_ + (1 - alpha2_) * cosine * cosine)), rule_(rule), cosines_(cosines) {
        // tan(theta_o/2); and of half the way from there to the horizon, and of half of that.
        const double below = sine_o_ / (1 + cosine_o_), rest = cosine_o_ / (1 + sine_o_);
        const double half = rest / (1 + root(1 + rest * rest));
        add_panel(below, std::min(2 * alpha, std::max(cosine_o_, 0.1 * alpha)), [this](double u) { about_o(-u); });
        add_panel(half, 2 * alpha, [this](double u) { about_o(u); });
        add_panel(half, alpha, [this](double u) { about_horizon(u); });
        sum_.single *= alpha2_ / host::pi, sum_.schlick *= alpha2_ / host::pi;
    }
    Albedos sum() const { return sum_; }

  private:
    template <class At>
    void add_panel(double length, double scale, At at) {
        if (length == 0) return;
        const double ratio = length / scale, end = host::log(ratio + root(ratio * ratio + 1));
        for (std::size_t i = 0; i < rule_.x.size(); ++i) {
            const double grown = host::exp((rule_.x[i] + 1) / 2 * end), shrunk = 1 / grown;
            const double u = scale * (grown - shrunk) / 2;
            weight_ = rule_.weight[i] / 2 * end * scale * (grown + shrunk) / 2 * 2 / (1 + u * u);
            at(u);
        }
    }
    // theta_i - theta_o = 2 atan u.
    void about_o(double u) {
        const double c = 1 / root(1 + u * u), s = u * c;
        const double sine_sum = sine_o_ * c + cosine_o_ * s, cosine_sum = cosine_o_ * c - sine_o_ * s;
        // cos(a + b) of a = (theta_o + theta_i)/2, b = (theta_i - theta_o)/2; and the sine.
        add(cosine_sum * c - sine_sum * s, sine_sum * c + cosine_sum * s, {sine_sum, cosine_sum, s, c});
    }
    // theta_i = pi/2 - 2 atan u.
    void about_horizon(double u) {
        const double cosine = 2 * u / (1 + u * u), sine = (1 - u * u) / (1 + u * u);
        const double cosine_difference = cosine * cosine_o_ + sine * sine_o_, cosine_sum = cosine * cosine_o_ - sine * sine_o_;
        auto half = [](double x) { return root(std::max(x, 0.0) / 2); };
        add(cosine, sine, {half(1 - cosine_sum), half(1 + cosine_sum), half(1 - cosine_difference), half(1 + cosine_difference)});
    }
    struct Halves {
        double sine_sum, cosine_sum, sine_difference, cosine_difference;
    };
    void add(double cosine, double sine, const Halves& h) {
        const double root_i = root(alpha2_ + (1 - alpha2_) * cosine * cosine);
        const double visible = weight_ * sine * cosine / (2 * (cosine_o_ * root_i + cosine * root_o_));
        const Ring ring = ring_of(h.sine_sum, h.cosine_sum, h.sine_difference, h.cosine_difference, alpha2_);
        sum_.single += visible * closed(ring);
        sum_.schlick += visible * of_schlick(ring, cosines_);
    }

    double cosine_o_, sine_o_, alpha2_, root_o_;
    const Rule& rule_;
    const std::vector<double>& cosines_;
    double weight_ = 0;
    Albedos sum_{};
};

double cosine_of(int column) {
    const double x = double(column) / (microfacet_columns - 1);
    return x * x * x * x;
}
double alpha_of(int row) {
    const double y = double(first_row_root) + (1 - double(first_row_root)) * row / (microfacet_rows - 1);
    return row == 0 ? double(least_alpha) : y * y * y * y;
}

using Column = std::array<double, microfacet_columns>;

// 2 integral of f cos dcos, of what lies linear between columns, exactly: by a rule of five nodes.
double mean_of(const Column& f, const Rule& rule) {
    const double width = 1.0 / (microfacet_columns - 1);
    double sum = 0;
    for (std::size_t k = 0; k + 1 < f.size(); ++k)
        for (std::size_t i = 0; i < rule.x.size(); ++i) {
            const double t = (rule.x[i] + 1) / 2, x = (double(k) + t) * width, x2 = x * x, x4 = x2 * x2;
            sum += rule.weight[i] / 2 * width * 8 * x4 * x2 * x * (f[k] + (f[k + 1] - f[k]) * t);
        }
    return sum;
}

struct Row {
    Column s, t;
    double a, b;
};
Row row_of(int number, const Rule& fine, const Rule& five, const std::vector<double>& cosines) {
    const double alpha = alpha_of(number), f0 = double(dielectric_f0);
    Column lost, schlick, dark;
    for (std::size_t c = 0; c < lost.size(); ++c) {
        const Albedos a = OverDirections(cosine_of(int(c)), alpha, fine, cosines).sum();
        lost[c] = std::max(1 - a.single, 0.0), schlick[c] = a.schlick;
    }
    const double lost_mean = mean_of(lost, five), fresnel_mean = f0 + (1 - f0) / 21;
    const double again = fresnel_mean * fresnel_mean * (1 - lost_mean) / (1 - fresnel_mean * lost_mean);
    for (std::size_t c = 0; c < lost.size(); ++c)
        dark[c] = 1 - (f0 * (1 - lost[c] - schlick[c]) + schlick[c] + lost[c] * again);
    Row row{lost, dark, root(host::pi * lost_mean) / alpha, root(host::pi * mean_of(dark, five))};
    for (double& s : row.s) s /= row.a;
    for (double& t : row.t) t /= row.b;
    return row;
}

MicrofacetTables made() {
    const Rule fine = gauss_legendre(table_nodes), five = gauss_legendre(5);
    const std::vector<double> cosines = cosines_of(table_turns);
    std::vector<Row> rows(microfacet_rows);
    parallel_bands(microfacet_rows, 1, 0, [&](int first, int last) {
        for (int r = first; r < last; ++r) rows[std::size_t(r)] = row_of(r, fine, five, cosines);
    });
    MicrofacetTables tables;
    for (std::size_t r = 0; r < rows.size(); ++r) {
        const Row &row = rows[r], &next = rows[std::min(r + 1, rows.size() - 1)];
        tables.rows.insert(tables.rows.end(), {float(row.a), float(row.b), float(next.a), float(next.b)});
        for (std::size_t c = 0; c < row.s.size(); ++c) {
            const std::size_t d = std::min(c + 1, row.s.size() - 1);
            tables.cells.insert(tables.cells.end(), {float(row.s[c]), float(row.t[c]), float(row.s[d]), float(row.t[d])});
        }
    }
    return tables;
}

}  // namespace

Albedos albedos(double cosine, double alpha, int nodes, int turns) {
    return OverDirections(cosine, alpha, gauss_legendre(nodes), cosines_of(turns)).sum();
}

const MicrofacetTables& microfacet_tables() {
    static const MicrofacetTables tables = made();
    return tables;
}

}  // namespace plumb::reference
