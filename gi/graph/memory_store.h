// A store that ends with the program: what one graph made and another of the same run need not.
#pragma once

#include <map>

#include "gi/graph/store.h"

namespace plumb::graph {

class MemoryStore : public Store {
  public:
    std::optional<Bundle> find(Key key) override {
        const auto at = kept_.find(key);
        return at == kept_.end() ? std::nullopt : std::optional(at->second);
    }
    void keep(Key key, const Bundle& bundle, const std::string&) override {
        Bundle own = bundle;
        for (Array& a : own.arrays) a.bytes.own();
        kept_[key] = std::move(own);
    }
    std::size_t size() const { return kept_.size(); }

  private:
    std::map<Key, Bundle> kept_;
};

}  // namespace plumb::graph
