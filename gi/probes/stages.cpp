#include "core/kernel_stage.h"
#include "gi/probes/coefficients.h"
#include "gi/probes/density.h"
#include "gi/probes/indirect_shadow.h"
#include "gi/probes/lambda.h"
#include "gi/probes/radiance.h"
#include "gi/probes/level.h"
#include "gi/probes/lightmap_uv.h"
#include "gi/probes/lookup.h"
#include "gi/probes/relief.h"
#include "gi/probes/share.h"
#include "gi/probes/supports.h"
#include "gi/probes/update.h"
#include "twins/gi.probes.basis.comp.h"
#include "gi/probes/volume.h"
#include "twins/gi.probes.coefficients.comp.h"
#include "twins/gi.probes.density.comp.h"
#include "twins/gi.probes.lambda.comp.h"
#include "twins/gi.probes.radiance.comp.h"
#include "twins/gi.probes.level.comp.h"
#include "twins/gi.probes.lightmap_uv.comp.h"
#include "twins/gi.probes.lookup.comp.h"
#include "twins/gi.probes.irradiance.comp.h"
#include "twins/gi.probes.lightmap_write.comp.h"
#include "twins/gi.probes.share.comp.h"
#include "twins/gi.probes.supports.comp.h"
#include "twins/gi.probes.indirect_shadow.comp.h"
#include "twins/gi.probes.relief.comp.h"
#include "twins/gi.probes.volume.comp.h"

namespace plumb {

using namespace probes;

// Their items are for one lane.
template <>
inline constexpr bool by_packets<BasisKernel> = false;
template <>
inline constexpr bool by_packets<IrradianceKernel> = false;
template <>
inline constexpr bool by_packets<LightmapKernel> = false;
template <>
inline constexpr bool by_packets<DensityKernel> = false;
template <>
inline constexpr bool by_packets<SupportsKernel> = false;
template <>
inline constexpr bool by_packets<CoefficientsKernel> = false;
template <>
inline constexpr bool by_packets<LambdaKernel> = false;

template <>
const StageBinding& stage<DensityKernel>() { return made<DensityKernel, twins::gi_probes_density_comp>(); }
template <>
const StageBinding& stage<SupportsKernel>() { return made<SupportsKernel, twins::gi_probes_supports_comp>(); }
template <>
const StageBinding& stage<ShareKernel>() { return made<ShareKernel, twins::gi_probes_share_comp>(); }
template <>
const StageBinding& stage<CoefficientsKernel>() { return made<CoefficientsKernel, twins::gi_probes_coefficients_comp>(); }
template <>
const StageBinding& stage<RadianceKernel>() { return made<RadianceKernel, twins::gi_probes_radiance_comp>(); }
template <>
const StageBinding& stage<LambdaKernel>() { return made<LambdaKernel, twins::gi_probes_lambda_comp>(); }
template <>
const StageBinding& stage<LevelKernel>() { return made<LevelKernel, twins::gi_probes_level_comp>(); }
template <>
const StageBinding& stage<LightmapUvKernel>() { return made<LightmapUvKernel, twins::gi_probes_lightmap_uv_comp>(); }
template <>
const StageBinding& stage<LookupKernel>() { return made<LookupKernel, twins::gi_probes_lookup_comp>(); }
template <>
const StageBinding& stage<BasisKernel>() { return made<BasisKernel, twins::gi_probes_basis_comp>(); }
template <>
const StageBinding& stage<IrradianceKernel>() { return made<IrradianceKernel, twins::gi_probes_irradiance_comp>(); }
template <>
const StageBinding& stage<LightmapKernel>() { return made<LightmapKernel, twins::gi_probes_lightmap_write_comp>(); }
template <>
const StageBinding& stage<VolumeKernel>() { return made<VolumeKernel, twins::gi_probes_volume_comp>(); }
template <>
const StageBinding& stage<IndirectShadowKernel>() { return made<IndirectShadowKernel, twins::gi_probes_indirect_shadow_comp>(); }
template <>
const StageBinding& stage<ReliefKernel>() { return made<ReliefKernel, twins::gi_probes_relief_comp>(); }

}  // namespace plumb
