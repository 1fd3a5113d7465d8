#include <fcntl.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>

#include "files.h"
#include "io/part_file.h"

using namespace plumb;
using namespace plumb::io;

TEST_CASE("file: what is written is read back, and nothing else lies beside it", "[io]") {
    const Folder folder;
    const std::string path = folder / "a.txt";
    write_file(path, {"one ", "", "two"});
    CHECK(read_text(path) == "one two");
    write_text(path, "three");
    CHECK(read_text(path) == "three");
    CHECK(folder.files() == 1);
}

TEST_CASE("file: a path that cannot be read is one line with the path and the reason", "[io][robustness]") {
    const Folder folder;
    require_message(error_of([&] { read_text(folder / "none.txt"); }), {"none.txt", "No such file"});
    require_message(error_of([&] { read_text(folder / ""); }), {"not a regular file"});
    require_message(error_of([&] { read_text("/dev/zero"); }), {"/dev/zero", "not a regular file"});
    require_message(error_of([&] { read_text(folder.put("big.txt", "12345"), 4); }),
                    {"big.txt", "5 bytes", "limit is 4"});
    require_message(error_of([&] { read_text(std::string("a\0b", 3)); }), {"NUL"});
    require_message(error_of([&] { read_text(folder / "two\nlines"); }), {"two\\x0alines"});
}

TEST_CASE("file: a path that cannot be written is one line, and nothing is left", "[io][robustness]") {
    const Folder folder;
    const std::string file = folder.put("file", "x");
    require_message(error_of([&] { write_text(folder / "none/a.txt", "x"); }), {"none/a.txt", "No such file"});
    require_message(error_of([&] { write_text(file + "/a.txt", "x"); }), {"a.txt", "Not a directory"});
    require_message(error_of([&] { make_folder(file); }), {file});
    require_message(error_of([&] { make_folder(file + "/sub"); }), {file});
    std::filesystem::create_directory(folder / "taken");
    require_message(error_of([&] { write_text(folder / "taken", "x"); }), {"taken", "cannot be written"});
    CHECK(folder.files() == 2);
}

TEST_CASE("file: pipes, devices and links stay what they are", "[io][robustness]") {
    const Folder folder;
    // Whoever reads the pipe gets the text: as much as it holds waits in it.
    const std::string pipe = folder / "pipe";
    REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
    const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
    REQUIRE(reader >= 0);
    write_file(pipe, {"one ", "two"});
    char bytes[8] = {};
    CHECK(::read(reader, bytes, sizeof bytes) == 7);
    CHECK(std::string(bytes) == "one two");
    ::close(reader);
    CHECK(std::filesystem::is_fifo(pipe));

    // A link's file is written, whether it is there or not.
    folder.put("named.txt", "a longer text");
    std::filesystem::create_symlink("named.txt", folder / "link");
    std::filesystem::create_symlink("new.txt", folder / "to_new");
    write_text(folder / "link", "text");
    write_text(folder / "to_new", "new");
    CHECK(read_text(folder / "named.txt") == "text");
    CHECK(read_text(folder / "new.txt") == "new");
    CHECK(std::filesystem::is_symlink(folder / "link"));
    CHECK(std::filesystem::is_symlink(folder / "to_new"));

    std::filesystem::create_symlink("/dev/full", folder / "full");
    require_message(error_of([&] { write_text(folder / "full", "x"); }), {"full", "cannot be written", "No space"});
    CHECK(std::filesystem::is_symlink(folder / "full"));
    CHECK(folder.files() == 6);
}

TEST_CASE("file: a full disk leaves the old file and no other", "[io][robustness]") {
    // A limit on file sizes stands for the full disk: write() fails in the middle.
    const Folder folder;
    const std::string path = folder.put("a.txt", "old");
    std::signal(SIGXFSZ, SIG_IGN);
    rlimit before;
    getrlimit(RLIMIT_FSIZE, &before);
    const rlimit small{1000, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
    const std::string message = error_of([&] { write_text(path, std::string(5000, 'x')); });
    setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, SIG_DFL);
    require_message(message, {"a.txt", "cannot be written", "File too large"});
    CHECK(read_text(path) == "old");
    CHECK(folder.files() == 1);
}

TEST_CASE("file: a signal in the middle of a write leaves the old file and no other", "[io][robustness]") {
    const Folder folder;
    const std::string path = folder.put("a.txt", "old");
    const pid_t child = fork();
    if (child == 0) {
        // SIGXFSZ arrives from within write().
        const rlimit small{1000, 1000};
        setrlimit(RLIMIT_FSIZE, &small);
        std::signal(SIGXFSZ, [](int) {
            remove_unfinished_files();
            _exit(130);
        });
        write_text(path, std::string(5000, 'x'));
        _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    CHECK(WEXITSTATUS(status) == 130);
    CHECK(read_text(path) == "old");
    CHECK(folder.files() == 1);
}

TEST_CASE("file: what a killed writer has left is removed, what is being written is not", "[io][robustness]") {
    namespace fs = std::filesystem;
    const Folder folder;
    const auto left = [&] {
        std::vector<std::string> names;
        for (const fs::directory_entry& e : fs::directory_iterator(folder / "")) names.push_back(e.path().string());
        return names;
    };
    const pid_t child = fork();
    if (child == 0) {
        const rlimit small{1000, 1000};
        setrlimit(RLIMIT_FSIZE, &small);
        std::signal(SIGXFSZ, SIG_DFL);  // from within write(), without a handler: as if killed
        write_text(folder / "a.txt", std::string(5000, 'x'));
        _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    REQUIRE(WIFSIGNALED(status));
    REQUIRE(left().size() == 1);
    const std::string killed = left()[0];
    CHECK(killed.ends_with(".part"));
    CHECK(fs::path(killed).filename().string().starts_with(".a.txt."));
    CHECK(remove_abandoned(killed));
    CHECK(left().empty());
    CHECK_FALSE(remove_abandoned(killed));

    // A lock says that its writer lives, however old it is; two names of one path are two.
    const std::string written = part_name(folder / "a.txt");
    CHECK(written != part_name(folder / "a.txt"));
    const int writer = ::open(written.c_str(), O_WRONLY | O_CREAT, 0600);
    REQUIRE(::flock(writer, LOCK_EX) == 0);
    const auto age = [](const std::string& file) { fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::hours(25)); };
    age(written);
    CHECK_FALSE(remove_abandoned(written));
    CHECK(fs::exists(written));
    ::close(writer);
    CHECK(remove_abandoned(written));

    // Of another machine nobody here knows whether it lives: a day.
    const std::string other = folder.put(".a.txt.00000000-1-0.part", "half"), nameless = folder.put(".a.txt.1-0.part", "half");
    for (const std::string& file : {other, nameless}) {
        CHECK_FALSE(remove_abandoned(file));
        age(file);
        CHECK(remove_abandoned(file));
    }
    // Not what is no file.
    fs::create_directory(folder / ".a.txt.2-0.part");
    fs::create_symlink("nowhere", folder / ".a.txt.3-0.part");
    CHECK_FALSE(remove_abandoned(folder / ".a.txt.2-0.part"));
    CHECK_FALSE(remove_abandoned(folder / ".a.txt.3-0.part"));
}

TEST_CASE("file: names are taken apart", "[io]") {
    CHECK(folder_of("a/b.obj") == "a");
    CHECK(folder_of("b.obj") == "");
    CHECK(beside("a/b.toml", "c.obj") == "a/c.obj");
    CHECK(beside("a/b.toml", "/c.obj") == "/c.obj");
    CHECK(extension_of("a.b/C.EXR") == "exr");
    CHECK(extension_of("a.b/c") == "");
    CHECK(stem_of("a/b.c.obj") == "b.c");
    CHECK(printable("a\tb") == "a\\x09b");
    CHECK(printable("abcdef", 3) == "abc...");
}
