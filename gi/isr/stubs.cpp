// Stand-ins until the stages are written.
#include "core/error.h"
#include "gi/isr/bindings.h"
#define STUB __attribute__((weak))
namespace plumb::isr {
namespace { [[noreturn]] void none() { throw InputError("not there yet"); } }
STUB CoarseCamera coarse_camera(const Camera&, glm::ivec2, int) { none(); }
STUB void run_downsample(const IsrParams&, Coarse, const DownsampleInputs&, const RunOptions&, Image4&) { none(); }
STUB Pattern gather_pattern(const IsrParams&) { none(); }
STUB Pattern ssao_pattern(const IsrParams&) { none(); }
STUB Excess excess_of(const Image4&, const Image4&) { none(); }
STUB std::vector<TapValue> explain_downsample(const IsrParams&, Coarse, const DownsampleInputs&, glm::ivec2) { none(); }
STUB StageData downsample_data(const IsrParams&, Coarse, const DownsampleInputs&) { none(); }
STUB void run(const IsrParams&, const GatherInputs&, const RunOptions&, Image4&) { none(); }
STUB std::vector<TapValue> explain(const IsrParams&, const GatherInputs&, glm::ivec2) { none(); }
STUB StageData gather_data(const IsrParams&, const GatherInputs&) { none(); }
STUB void run(const IsrParams&, const SsaoInputs&, const RunOptions&, Image4&) { none(); }
STUB std::vector<TapValue> explain(const IsrParams&, const SsaoInputs&, glm::ivec2) { none(); }
STUB StageData ssao_data(const IsrParams&, const SsaoInputs&) { none(); }
STUB void run(const IsrParams&, const BounceInputs&, const RunOptions&, Image4&) { none(); }
STUB std::vector<TapValue> explain(const IsrParams&, const BounceInputs&, glm::ivec2) { none(); }
STUB StageData bounce_data(const IsrParams&, const BounceInputs&) { none(); }
STUB void run(const IsrParams&, const BlurInputs&, const RunOptions&, Image4&) { none(); }
STUB std::vector<TapValue> explain(const IsrParams&, const BlurInputs&, glm::ivec2) { none(); }
STUB StageData blur_data(const IsrParams&, const BlurInputs&) { none(); }
STUB void run(const IsrParams&, const UpsampleInputs&, const RunOptions&, Image4&) { none(); }
STUB std::vector<TapValue> explain(const IsrParams&, const UpsampleInputs&, glm::ivec2) { none(); }
STUB StageData upsample_data(const IsrParams&, const UpsampleInputs&) { none(); }
STUB void run(const IsrParams&, const ComposeInputs&, const RunOptions&, Image4&) { none(); }
STUB std::vector<TapValue> explain(const IsrParams&, const ComposeInputs&, glm::ivec2) { none(); }
STUB StageData compose_data(const IsrParams&, const ComposeInputs&) { none(); }
STUB StageInfo info_downsample() { StageInfo s; s.name = "isr.downsample"; return s; }
STUB const StageBinding& downsample_binding() { static const StageBinding b = [] { StageBinding n; n.info.name = "isr.downsample"; return n; }(); return b; }
STUB StageInfo info_gather() { StageInfo s; s.name = "isr.gather"; return s; }
STUB const StageBinding& gather_binding() { static const StageBinding b = [] { StageBinding n; n.info.name = "isr.gather"; return n; }(); return b; }
STUB StageInfo info_ssao() { StageInfo s; s.name = "isr.ssao"; return s; }
STUB const StageBinding& ssao_binding() { static const StageBinding b = [] { StageBinding n; n.info.name = "isr.ssao"; return n; }(); return b; }
STUB StageInfo info_bounce() { StageInfo s; s.name = "isr.bounce"; return s; }
STUB const StageBinding& bounce_binding() { static const StageBinding b = [] { StageBinding n; n.info.name = "isr.bounce"; return n; }(); return b; }
STUB StageInfo info_blur() { StageInfo s; s.name = "isr.blur"; return s; }
STUB const StageBinding& blur_binding() { static const StageBinding b = [] { StageBinding n; n.info.name = "isr.blur"; return n; }(); return b; }
STUB StageInfo info_upsample() { StageInfo s; s.name = "isr.upsample"; return s; }
STUB const StageBinding& upsample_binding() { static const StageBinding b = [] { StageBinding n; n.info.name = "isr.upsample"; return n; }(); return b; }
STUB StageInfo info_compose() { StageInfo s; s.name = "isr.compose"; return s; }
STUB const StageBinding& compose_binding() { static const StageBinding b = [] { StageBinding n; n.info.name = "isr.compose"; return n; }(); return b; }
}  // namespace plumb::isr
