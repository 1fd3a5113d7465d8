// What is kept between runs: one file for each key in a folder, of one kind with a limit of its own.
#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "gi/graph/store.h"

namespace plumb::cli {

// $PLUMB_CACHE, else $XDG_CACHE_HOME/plumbline, else ~/.cache/plumbline; empty where none of the three is set.
std::string cache_folder();

// A file is a bundle with a checksum (io/bundle_file.h) that holds its key again, written beside its place and published by
// renaming. One that is broken or belongs to another key is never believed: it counts as not there, is written anew, and
// notes() says so. Whatever fails is a note. The key includes the bytes of the program itself, so that no build believes what
// another has made. Several programs may use one folder at once.
class FileStore : public graph::Store {
  public:
    struct Limits {
        std::uint64_t max_bytes = std::uint64_t(4) << 30;  // of all files of this kind; those that were used last stay
        std::uint64_t program = 0;  // what stands for the program in the key; 0: its own bytes. Another is for who keeps
                                    // things in a folder of his own and says for how long
        std::string made = "made";  // "traced": what is done anew where a file is not believed
    };
    // kind: files end in ".<kind>": letters and digits.
    FileStore(std::string folder, std::string kind, Limits limits);
    FileStore(std::string folder, std::string kind) : FileStore(std::move(folder), std::move(kind), Limits{}) {}

    std::optional<Bundle> find(graph::Key key) override { return find(key, limits_.max_bytes); }
    // One larger than `most` bytes and its header is not even read.
    std::optional<Bundle> find(graph::Key key, std::uint64_t most);
    void keep(graph::Key key, const Bundle& bundle, const std::string& what) override;

    // What this store has found or kept it does not remove while it lives, whatever the limit: a bake that runs needs it.
    // Another program that keeps to the limit of the same kind does not know of it.
    void pin() { pins_ = true; }

    // What its user has to know: one line each.
    const std::vector<std::string>& notes() const { return notes_; }
    void note(std::string text) { notes_.push_back(std::move(text)); }
    std::string path_of(graph::Key key);

  private:
    graph::Key own_key(graph::Key key);
    // Removes what is beyond the limit, once what is known to be free is used up.
    void make_room(std::uint64_t written);
    // Bytes that are left.
    std::uint64_t remove_oldest() const;
    bool is_part(const std::filesystem::path& path) const;
    // What runs that were killed while they wrote have left: once, before the folder is first used.
    void remove_abandoned();

    std::string folder_, kind_;
    Limits limits_;
    bool pins_ = false, cleaned_ = false;
    std::uint64_t room_ = 0;
    int unseen_ = 0;  // files kept since the folder was looked through
    std::set<std::string> used_;
    std::vector<std::string> notes_;
};

}  // namespace plumb::cli
