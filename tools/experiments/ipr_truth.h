// plumb experiment ipr: path traced truth at receivers and at pixels.
#pragma once

#include "gi/probes/receiver_irradiance.h"
#include "raster/gbuffer.h"
#include "tools/experiments/ipr.h"

namespace plumb::cli {

inline constexpr double ipr_swing = 0.5;  // relative error of full colour

// All light but what lamps send straight there; emitting surfaces and the sky are part of it.
probes::ReceiverIrradiance trace_all_receivers(const Scene& scene, const probes::Receivers& receivers, int samples, Rays rays,
                                               const RunOptions& options);
// Every k-th of the receivers, so that at most request.receivers are left.
IprTruth trace_receivers(const Scene& scene, const probes::Receivers& receivers, const IprRequest& request, Rays rays, const RunOptions& options);
void trace_pixels(const Scene& scene, const raster::GBuffer& seen, const IprRequest& request, Rays rays, const RunOptions& options, Image4& mean,
                  Image4& error);

}  // namespace plumb::cli
