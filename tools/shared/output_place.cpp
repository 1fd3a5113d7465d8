#include "tools/shared/output_place.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "core/error.h"
#include "io/file.h"
#include "io/part_file.h"

namespace plumb::cli {

namespace fs = std::filesystem;

namespace {

void remove_left_overs(const std::string& folder, const std::string& name) {
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder.empty() ? "." : folder, error)) {
        const std::string left = entry.path().filename().string();
        if (left.starts_with(name) && left.ends_with(".part")) io::remove_abandoned(entry.path().string());
    }
}

}  // namespace

void require_place(const std::string& file) {
    std::error_code error;
    const fs::file_status there = fs::symlink_status(file, error);
    if (fs::exists(there) && !fs::is_regular_file(there)) return;
    const std::string name = "." + fs::path(file).filename().string() + ".";
    const std::string tried = io::part_name(file);
    if (!std::ofstream(tried)) throw InputError(io::shown(file), "", std::string("cannot be written: ") + std::strerror(errno));
    fs::remove(tried, error);
    remove_left_overs(io::folder_of(file), name);
}

}  // namespace plumb::cli
