#include "tools/shared/machine_load.h"

#include <stdlib.h>

#include <limits>

namespace plumb::cli {

double machine_load() {
    double load = 0;
    return getloadavg(&load, 1) == 1 ? load : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace plumb::cli
