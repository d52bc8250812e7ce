// A list with gaps, for a graph whose ids are never used again.
#pragma once

#include <cstddef>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace dynemo {

/// Grows at the end; an index keeps its meaning for ever. Removed entries read as T(), and once all
/// of a stretch are, it takes next to no memory: what is left of a long life is a byte per index.
template <class T>
class Slots {
 public:
  /// Visits the entries that are there, ascending by index.
  class const_iterator {
   public:
    using iterator_category = std::forward_iterator_tag;
    using value_type = T;
    using difference_type = std::ptrdiff_t;
    using pointer = const T*;
    using reference = const T&;

    const_iterator() = default;
    const_iterator(const Slots& slots, std::size_t index) : slots_(&slots), index_(index) {
      skip();
    }
    reference operator*() const { return (*slots_)[index_]; }
    pointer operator->() const { return &(*slots_)[index_]; }
    const_iterator& operator++() {
      ++index_;
      skip();
      return *this;
    }
    const_iterator operator++(int) {
      const const_iterator before = *this;
      ++*this;
      return before;
    }
    bool operator==(const const_iterator& other) const { return index_ == other.index_; }

   private:
    void skip() {
      while (index_ < slots_->size() && !(*slots_)[index_])
        index_ += slots_->pages_[index_ / kPage].entries.empty() ? kPage - index_ % kPage : 1;
      if (index_ > slots_->size()) index_ = slots_->size();
    }
    const Slots* slots_ = nullptr;
    std::size_t index_ = 0;
  };

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const_iterator begin() const { return {*this, 0}; }
  const_iterator end() const { return {*this, size_}; }

  /// The entry, or T() when it was removed. The index must be less than the size.
  const T& operator[](std::size_t index) const {
    const Page& page = pages_[index / kPage];
    return page.entries.empty() ? none() : page.entries[index % kPage];
  }
  /// The same; throws std::out_of_range when there has never been such an index.
  const T& at(std::size_t index) const {
    if (index >= size_) throw std::out_of_range("no such slot: " + std::to_string(index));
    return (*this)[index];
  }
  /// The entry, for changes that leave it there; it must not have been removed.
  T& present(std::size_t index) { return pages_[index / kPage].entries[index % kPage]; }

  void push_back(T entry) {
    open().entries.push_back(std::move(entry));
    ++pages_.back().used;
  }
  /// An index of which the entry is removed already.
  void skip() {
    open().entries.emplace_back();
    tidy(pages_.back());
  }
  /// There must be an entry.
  void remove(std::size_t index) {
    Page& page = pages_[index / kPage];
    page.entries[index % kPage] = T();
    --page.used;
    tidy(page);
  }

 private:
  static constexpr std::size_t kPage = 32;
  struct Page {
    std::vector<T> entries;
    std::size_t used = 0;
  };
  static const T& none() {
    static const T nothing{};
    return nothing;
  }
  Page& open() {
    if (size_++ % kPage == 0) {
      pages_.emplace_back();
      pages_.back().entries.reserve(kPage);
    }
    return pages_.back();
  }
  static void tidy(Page& page) {
    if (page.used == 0 && page.entries.size() == kPage) std::vector<T>().swap(page.entries);
  }

  std::vector<Page> pages_;
  std::size_t size_ = 0;
};

}  // namespace dynemo
