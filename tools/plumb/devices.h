// What commands that run twins on a Vulkan device share.
#pragma once

#include "tools/plumb/cli.h"

namespace plumb::cli {

// --device NAME: a part of the device's name, or its index in `plumb devices`.
void add_device_option(CLI::App& command, std::string& device);

// Throws InputError where this program was built without Vulkan; to be called before anything is computed for a device.
void require_vulkan(const std::string& what);

}  // namespace plumb::cli
