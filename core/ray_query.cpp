#include "core/ray_query.h"

namespace plumb {

RayQuery::~RayQuery() = default;

}  // namespace plumb
