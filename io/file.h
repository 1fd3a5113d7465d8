// Files whole: read with a limit, written under a temporary name and renamed.
//
// A file that io/ writes is either complete or not there: an error, a full disk or Ctrl-C leaves what was at its path.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace plumb::io {

inline constexpr std::size_t max_text_bytes = std::size_t(1) << 31;
inline constexpr std::size_t max_file_bytes = std::size_t(1) << 36;

// All bytes of a regular file. Throws InputError: missing, not a regular file, unreadable, above the limit.
std::vector<unsigned char> read_bytes(const std::string& path, std::size_t limit = max_file_bytes);
std::string read_text(const std::string& path, std::size_t limit = max_text_bytes);

// One part after another into one file. Throws InputError naming the path and what the system says.
void write_file(const std::string& path, const std::vector<std::string_view>& parts);
void write_text(const std::string& path, const std::string& text);

// Makes the folder and those above it; throws InputError.
void make_folder(const std::string& path);

// Removes what a write in progress has left. For handlers of signals: calls nothing but unlink.
void remove_unfinished_files() noexcept;

std::string folder_of(const std::string& path);  // "a/b.obj" -> "a", "b.obj" -> ""
// `name` as seen from the folder of `path`; an absolute name stays.
std::string beside(const std::string& path, const std::string& name);
std::string extension_of(const std::string& path);  // in lower case, without the dot
std::string stem_of(const std::string& path);       // "a/b.obj" -> "b"

// For messages: at most `limit` bytes of `text`, control characters written as \xNN, so that a message stays one line.
std::string printable(std::string_view text, std::size_t limit = 60);
// The name of a file in messages: all of it.
std::string shown(const std::string& path);

}  // namespace plumb::io
