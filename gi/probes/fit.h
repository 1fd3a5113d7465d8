// Fitted transport: the coefficients by which a receiver gathers from probes, chosen so that they err least.
//
// A probe's harmonics are 64 means over what its rays met: lambda_j = sum_r w_r Y_j(r) f(r). What a receiver asks for is a mean over
// what its own rays met: E = sum_k f_k L(x_k). IPR (9) takes L(x_k) from the harmonics at the direction of x_k, which shows a feature
// no larger than 25 degrees together with all that lies beside it: a lit floor brightens the dark foot of a box. But where both kinds
// of rays ended is known, and light that leaves two near points of one surface is mostly alike. With
//
//     C(x, y) = ((1 + n_x . n_y) / 2)^4 / (1 + |x - y| / range)^2
//
// as the covariance of the radiance that leaves x and y, the linear estimate sum_ij alpha_ij lambda_ij of the least expected error
// that is exact for constant radiance ("ordinary kriging": Matheron 1963, Principles of geostatistics) is
//
//     (W^T C W + nugget) alpha + mu W^T 1 = W^T C(hits of probes, hits of receiver) f,    1^T W alpha = sum_k f_k
//
// W the weights w_r Y_j(r) of the hits of all probes that support the receiver. Of a receiver's rays those count whose end some probe
// sees, as in share_kernel.h. A probe that sees less than a quarter of what another does is not asked: it knows other rooms.
//
// differs: IPR (9), which is `interpolated`. The run time does not know which of the two made its matrices.
#pragma once

#include <map>
#include <memory>

#include "gi/probes/transport.h"

namespace plumb::probes {

class Fit {
  public:
    // Traces the probes' rays. range: m, how far apart light is alike by a quarter.
    Fit(const TransportScene& scene, const TransportParams& params, double range_m, const RunOptions& options);
    ~Fit();

    // Writes over alpha, [count][slots][(degree + 1)^2] as block_coefficients() made it: the standing probes' of receivers whose rays
    // end where one of them sees. supports: of the block's receivers, whose first is block.first.
    void coefficients(const TracedBlock& block, const Supports& supports, const RunOptions& options, float* alpha);

  private:
    struct Probe;
    struct Solver;
    struct AskedProbe {
        std::int32_t probe;
        int slot;
    };
    using Asked = std::vector<AskedProbe>;  // by ascending probe
    std::vector<int> asked_slots(const TracedBlock& block, int receiver) const;
    using Group = std::pair<std::vector<int>, std::vector<int>>;  // probes that ascend, and the receivers that ask them
    void prepare(const std::vector<Group>& groups, const RunOptions& options);
    Buffer<double> products(const Probe& a, const Probe& b, Isa isa) const;
    Solver solver_of(const std::vector<int>& set, Isa isa) const;
    Buffer<double> fitted(const TracedBlock& block, int receiver, const Asked& asked, const Solver& solver, Isa isa) const;

    int coefficients_;
    float scale_;               // 1/m
    std::int32_t sky_;          // index of the sky among the probes; -2: none
    std::vector<Probe> probes_;
    std::map<std::pair<int, int>, Buffer<double>> products_;  // W_a^T C W_b, a <= b: [coefficient of a][of b]
};

}  // namespace plumb::probes
