#include "io/named_file.h"

#include <fmt/format.h>
#include <iconv.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "core/error.h"
#include "io/file.h"

namespace plumb::io {
namespace {

namespace fs = std::filesystem;

bool is_there(const fs::path& file) {
    std::error_code ignored;
    return fs::exists(file, ignored) && !fs::is_directory(file, ignored);
}

std::string slashed(std::string_view name) {
    std::string text(name);
    std::replace(text.begin(), text.end(), '\\', '/');
    return text;
}

std::string lower_case(std::string text) {
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
    return text;
}

// The first name of the folder, by its bytes, that differs from `name` by upper and lower case alone; "" for none.
std::string in_another_case(const fs::path& folder, const std::string& name) {
    const std::string wanted = lower_case(name);
    std::string best;
    std::error_code error;
    for (fs::directory_iterator at(folder.empty() ? "." : folder, error), end; !error && at != end; at.increment(error)) {
        const std::string found = at->path().filename().string();
        if (lower_case(found) == wanted && (best.empty() || found < best)) best = found;
    }
    return best;
}

}  // namespace

std::string find_named(const std::string& path, std::string_view name, const std::string& second_folder) {
    if (name.empty() || name.find('\0') != name.npos) return "";
    for (const std::string& written : {std::string(name), slashed(name)})
        for (const std::string& folder : {folder_of(path), second_folder})
            if (is_there(fs::path(folder) / written)) return (fs::path(folder) / written).string();
    return "";
}

std::string find_similar(const std::string& path, std::int64_t line, std::string_view name, const std::string& second_folder,
                         Findings& findings) {
    const std::string as_written = find_named(path, name, second_folder);
    const fs::path wanted = slashed(name);
    const std::string last = wanted.filename().string();
    if (!as_written.empty() || last.empty() || name.find('\0') != name.npos) return as_written;

    const auto takes = [&](const fs::path& file) {
        findings.add("name", path, line, fmt::format("there is no file \"{}\"", printable(name)),
                     shown(file.string()) + " is taken");
        return file.string();
    };
    const std::vector<fs::path> folders = {folder_of(path), second_folder};
    for (const fs::path& folder : folders)
        if (is_there(folder / last)) return takes(folder / last);
    for (const fs::path& folder : folders)
        for (const fs::path& where : {folder / wanted.parent_path(), folder}) {
            const std::string other = in_another_case(where, last);
            if (!other.empty() && is_there(where / other)) return takes(where / other);
        }
    return "";
}

std::string as_utf8(const std::string& path, std::string text) {
    const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
    if (byte(0) == 0xef && byte(1) == 0xbb && byte(2) == 0xbf) return text.substr(3);
    const bool little = byte(0) == 0xff && byte(1) == 0xfe, big = byte(0) == 0xfe && byte(1) == 0xff;
    if (!little && !big) return text;
    // The mark says which of its bytes come first.
    const iconv_t converter = ::iconv_open("UTF-8", "UTF-16");
    if (converter == iconv_t(-1)) throw InputError(shown(path), "", "is UTF-16, and this system cannot read that");
    std::string out(text.size() / 2 * 3, '\0');
    char *in = text.data(), *to = out.data();
    std::size_t left = text.size(), room = out.size();
    const bool whole = ::iconv(converter, &in, &left, &to, &room) != std::size_t(-1);
    ::iconv_close(converter);
    if (!whole) throw InputError(shown(path), fmt::format("byte {}", text.size() - left), "is not UTF-16");
    out.resize(out.size() - room);
    return out;
}

}  // namespace plumb::io
