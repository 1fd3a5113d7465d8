// plumb experiment ipr: path traced truth at receivers and at pixels.
#pragma once

#include "gi/probes/receiver_irradiance.h"
#include "gi/reference/reference.h"
#include "raster/gbuffer.h"
#include "tools/experiments/ipr.h"

namespace plumb::cli {

// All light but what lamps send straight there; emitting surfaces and the sky are part of it.
probes::ReceiverIrradiance trace_all_receivers(const Scene& scene, const probes::Receivers& receivers, int samples, Rays rays,
                                               const RunOptions& options);
// Every k-th of the receivers, so that at most request.receivers are left.
IprTruth trace_receivers(const Scene& scene, const probes::Receivers& receivers, const IprRequest& request, Rays rays, const RunOptions& options);
// At points, so many paths each: W/m2; 0 where the normal is 0.
void trace_points(const Scene& scene, const reference::PointInputs& points, int samples, Rays rays, const RunOptions& options, Image4& mean,
                  Image4& error);
inline int ipr_pixel_samples(const IprRequest& request) { return request.samples < 64 * 32 ? 32 : request.samples / 64; }

}  // namespace plumb::cli
