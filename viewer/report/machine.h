#pragma once

#include <vector>

#include "render/gl/context.h"
#include "viewer/report/data.h"

namespace maquette::report {

/// Program, processor, cores, memory, system, load at this moment, graphics device: what a time depends on.
std::vector<NamedValue> describe_machine(const DeviceInfo& device);

}  // namespace maquette::report
