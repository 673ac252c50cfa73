#pragma once

#include <array>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "liggghts/common/argument_list.h"

namespace millscale {

/// The keywords of a style, each with what reads its values. `parse` reads them in any order; its
/// error lists the keywords in the order in which they were added.
class Keywords {
 public:
  using Read = std::function<void(ArgumentList&)>;

  /// advice: what to do about an unknown keyword, for the error.
  explicit Keywords(std::string advice = {}) : advice_(std::move(advice)) {}

  Keywords& add(const std::string& key, Read read)
  {
    entries_.push_back({key, std::move(read)});
    return *this;
  }
  Keywords& word(const std::string& key, std::string& value)
  {
    return add(key, [key, &value](ArgumentList& list) { value = list.word(key); });
  }
  Keywords& number(const std::string& key, double& value)
  {
    return add(key, [key, &value](ArgumentList& list) { value = list.number(key); });
  }
  Keywords& positive(const std::string& key, double& value)
  {
    return add(key, [key, &value](ArgumentList& list) { value = list.positive(key); });
  }
  Keywords& count(const std::string& key, int& value)
  {
    return add(key, [key, &value](ArgumentList& list) { value = list.count(key); });
  }
  Keywords& vector(const std::string& key, std::array<double, 3>& value)
  {
    return add(key, [key, &value](ArgumentList& list) { value = list.vector(key); });
  }
  /// value: true after the word `yes`, false after `no`.
  Keywords& choice(const std::string& key, const std::string& yes, const std::string& no,
                   bool& value)
  {
    return add(key,
               [key, yes, no, &value](ArgumentList& list) { value = list.choice(key, yes, no); });
  }

  /// Throws std::invalid_argument that names the keyword.
  void parse(ArgumentList list) const
  {
    while (!list.done()) find(list.word("a keyword")).read(list);
  }

 private:
  struct Entry {
    std::string key;
    Read read;
  };

  const Entry& find(const std::string& key) const
  {
    std::string accepted;
    for (const Entry& entry : entries_) {
      if (entry.key == key) return entry;
      accepted += (accepted.empty() ? "" : ", ") + entry.key;
    }
    throw std::invalid_argument("unknown keyword '" + key + "'; accepted are " + accepted +
                                (advice_.empty() ? "" : "; " + advice_));
  }

  std::vector<Entry> entries_;
  std::string advice_;
};

}  // namespace millscale
