// A document of keys and values, TOML or JSON alike, with the place of each value for messages. Private to io/.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/fields.h"

namespace plumb::io {

struct DocumentEntry;

struct DocumentValue {
    enum class Kind { number, flag, text, list, table, other };
    Kind kind = Kind::other;
    double number = 0;
    bool is_integer = false;  // 25.0 of a JSON too
    std::int64_t integer = 0;
    bool flag = false;
    std::string text;
    std::vector<DocumentValue> list;
    std::vector<DocumentEntry> table;  // in the order of the file
    std::string place;                 // "line 12" of TOML, "/stage/0/size" of JSON
};

struct DocumentEntry {
    std::string key;
    DocumentValue value;
};

// By the name's extension: .json, else TOML. Throws InputError of one line for what neither parser takes, for values
// nested deeper than 16 (TOML) or 64 (JSON), and for a key that stands twice.
DocumentValue parse_document(const std::string& path, const std::string& text);

// Each function that reads a key also makes it known; finish() refuses the keys that nobody has asked for.
class DocumentReader {
  public:
    // `name` as messages show it: "input.position of stage 2 (rsm.disc)"; "" for the top of the file.
    DocumentReader(const DocumentValue& table, const std::string& path, std::string name)
        : table_(&table), path_(&path), name_(std::move(name)) {}

    const DocumentValue* find(const std::string& key);
    bool has(const std::string& key) { return find(key) != nullptr; }

    double number(const std::string& key, double fallback, double min, double max);
    std::int64_t integer(const std::string& key, std::int64_t fallback, std::int64_t min, std::int64_t max);
    bool flag(const std::string& key, bool fallback);
    std::string word(const std::string& key, const std::string& fallback);    // may be empty
    std::string filled(const std::string& key, const std::string& fallback);  // may not, where it is there
    const DocumentValue* table(const std::string& key);
    std::vector<const DocumentValue*> tables(const std::string& key);
    std::vector<std::string> keys() const;
    void finish() const;
    // Refuses every other key at once: a typo is the likeliest cause of what is found missing or wrong later.
    void allow(const std::vector<std::string>& keys);

    const std::string& name() const { return name_; }
    void rename(std::string name) { name_ = std::move(name); }
    std::string place() const { return place_of(*table_); }  // "manifest.toml: line 12"
    std::string place_of(const DocumentValue& value) const;
    // Throws InputError: "manifest.toml: line 12: stage 1 size = 3: <cause>".
    [[noreturn]] void fail(const std::string& key, const std::string& cause);

  private:
    const DocumentValue* table_;
    const std::string* path_;
    std::string name_;
    std::vector<std::string> known_;
};

}  // namespace plumb::io
