// Devices that the tests of this folder draw on.
#pragma once

#include <iostream>
#include <map>
#include <string>
#include <vector>

#include "tools/vulkan/device.h"

namespace plumb::test {

// The first device whose name holds one of these, with the validation layer on; null, and said so, where there is none.
// Made once, as devices are slow to make, and never ended: a driver's own statics may be gone before ours.
inline const vulkan::Device* first_of(const std::vector<std::string>& drivers, const char* missing) {
    for (const std::string& name : vulkan::device_names())
        for (const std::string& driver : drivers)
            if (name.find(driver) != name.npos) {
                static auto& devices = *new std::map<std::string, vulkan::Device*>;
                vulkan::Device*& device = devices[driver];
                if (!device) device = new vulkan::Device({.name = driver, .validate = true});
                return device;
            }
    std::cout << "SKIPPED: " << missing << "\n";
    return nullptr;
}
inline const vulkan::Device* lavapipe() {
    return first_of({"llvmpipe"}, "no lavapipe here (mesa-vulkan-drivers)");
}

}  // namespace plumb::test
