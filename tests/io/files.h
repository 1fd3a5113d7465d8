// A folder of its own for each test, and what tests of bad input ask of an error.
#pragma once

#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/error.h"
#include "io/file.h"

namespace plumb::io {

class Folder {
  public:
    Folder() {
        static int count = 0;
        path_ = std::filesystem::temp_directory_path() /
                ("plumb_test_io_" + std::to_string(::getpid()) + "_" + std::to_string(count++));
        std::filesystem::create_directories(path_);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    ~Folder() { std::filesystem::remove_all(path_); }

    std::string operator/(const std::string& name) const { return (path_ / name).string(); }
    std::string put(const std::string& name, const std::string& content) const {
        std::filesystem::remove(*this / name);  // a file system may wait for the disk where one is cut and written anew
        std::ofstream(*this / name, std::ios::binary) << content;
        return *this / name;
    }
    std::size_t files() const {
        return std::size_t(
            std::distance(std::filesystem::directory_iterator(path_), std::filesystem::directory_iterator()));
    }

  private:
    std::filesystem::path path_;
};

// The message of the InputError that `action` throws; "" if it throws none. Any other exception goes through.
template <class Action>
std::string error_of(Action action) {
    try {
        action();
        return "";
    } catch (const InputError& e) {
        return e.what();
    }
}

// One line that holds each of `parts`.
inline void require_message(const std::string& message, const std::vector<std::string>& parts) {
    CAPTURE(message);
    CHECK(message != "");
    CHECK(message.find('\n') == std::string::npos);
    for (const std::string& part : parts) CHECK_THAT(message, Catch::Contains(part));
}

// Feeds every beginning of `content`, and `content` with every byte changed, to `load`: it returns or throws
// InputError. Returns how many beginnings were accepted.
template <class Load>
std::size_t load_damaged(const Folder& folder, const std::string& name, const std::string& content, Load load) {
    std::size_t accepted = 0;
    for (std::size_t n = 0; n < content.size(); ++n) {
        const std::string path = folder.put(name, content.substr(0, n));
        accepted += error_of([&] { load(path); }).empty();
    }
    for (std::size_t n = 0; n < content.size(); ++n) {
        std::string changed = content;
        changed[n] = char(changed[n] ^ (1 << n % 8));
        const std::string path = folder.put(name, changed);
        error_of([&] { load(path); });
    }
    return accepted;
}

}  // namespace plumb::io
