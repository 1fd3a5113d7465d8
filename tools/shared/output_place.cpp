#include "tools/shared/output_place.h"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "core/error.h"
#include "io/file.h"

namespace plumb::cli {

namespace fs = std::filesystem;

namespace {

void remove_left_overs(const std::string& folder, const std::string& name) {
    const fs::file_time_type yesterday = fs::file_time_type::clock::now() - std::chrono::hours(24);
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder.empty() ? "." : folder, error)) {
        const std::string left = entry.path().filename().string();
        std::error_code gone;  // another run may have removed it since
        if (left.starts_with(name) && left.ends_with(".part") && entry.last_write_time(gone) < yesterday && !gone)
            fs::remove(entry.path(), gone);
    }
}

}  // namespace

void require_place(const std::string& file) {
    std::error_code error;
    const fs::file_status there = fs::symlink_status(file, error);
    if (fs::exists(there) && !fs::is_regular_file(there)) return;
    const std::string name = "." + fs::path(file).filename().string() + ".";
    const std::string tried = io::beside(file, name + "4294967295-0.part");
    if (!std::ofstream(tried)) throw InputError(io::shown(file), "", std::string("cannot be written: ") + std::strerror(errno));
    fs::remove(tried, error);
    remove_left_overs(io::folder_of(file), name);
}

}  // namespace plumb::cli
