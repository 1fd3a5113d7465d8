#include "core/shade_rows.h"
#include "gi/screen/blur_kernel.h"
#include "gi/screen/cells_kernel.h"
#include "gi/screen/horizon_kernel.h"
#include "gi/screen/lobe_kernel.h"
#include "gi/screen/mirror_kernel.h"
#include "gi/screen/occlude_kernel.h"
#include "gi/screen/reflect_kernel.h"
#include "gi/screen/reuse_kernel.h"
#include "gi/screen/ssao_kernel.h"

namespace plumb {

template struct Rows<screen::SsaoKernel, Isa::PLUMB_ISA>;
template struct Rows<screen::HorizonKernel, Isa::PLUMB_ISA>;
template struct Rows<screen::BlurKernel, Isa::PLUMB_ISA>;
template struct Rows<screen::OccludeKernel, Isa::PLUMB_ISA>;
template struct Rows<screen::ReuseKernel, Isa::PLUMB_ISA>;
template struct Rows<screen::LobeKernel, Isa::PLUMB_ISA>;
template struct Rows<screen::ReflectKernel, Isa::PLUMB_ISA>;
template struct Rows<screen::NearestKernel, Isa::PLUMB_ISA>;
template struct Rows<screen::CellsKernel, Isa::PLUMB_ISA>;
template struct Rows<screen::MirrorKernel, Isa::PLUMB_ISA>;

}  // namespace plumb
