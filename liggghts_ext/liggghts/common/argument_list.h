#pragma once

#include <array>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

namespace millscale {

/// Return the finite number in `text`, all of it: unlike atof, "4o" is not 4. The error names
/// `what`.
inline double number(const std::string& text, const std::string& what)
{
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !std::isfinite(value))
    throw std::invalid_argument(what + ": expected a number, got '" + text + "'");
  return value;
}

/// Reads the arguments of a style in order. Throws std::invalid_argument with the keyword, which
/// styles pass to the engine's error.
class ArgumentList {
 public:
  ArgumentList(int narg, char** arg, int first) : narg_(narg), arg_(arg), next_(first) {}

  bool done() const { return next_ >= narg_; }

  std::string word(const std::string& what)
  {
    if (done()) throw std::invalid_argument(what + ": expected a value, the command ends here");
    return arg_[next_++];
  }
  double number(const std::string& what) { return millscale::number(word(what), what); }

  int count(const std::string& what, int most = 1'000'000'000)
  {
    const double value = number(what);
    if (value < 0.0 || value != std::floor(value) || value > most)
      throw std::invalid_argument(what + ": expected a whole number from 0 to " +
                                  std::to_string(most) + ", got " + arg_[next_ - 1]);
    return static_cast<int>(value);
  }
  double positive(const std::string& what)
  {
    const double value = number(what);
    if (!(value > 0.0))
      throw std::invalid_argument(what + ": expected a number > 0, got " + arg_[next_ - 1]);
    return value;
  }
  std::array<double, 3> vector(const std::string& what)
  {
    return {number(what + " x"), number(what + " y"), number(what + " z")};
  }
  std::string one_of(const std::string& what, const std::vector<std::string>& words)
  {
    const std::string got = word(what);
    std::string accepted;
    for (const std::string& each : words) {
      if (got == each) return got;
      accepted += (accepted.empty() ? "" : ", ") + each;
    }
    throw std::invalid_argument(what + ": got '" + got + "', accepted are " + accepted);
  }
  bool choice(const std::string& what, const std::string& yes, const std::string& no)
  {
    return one_of(what, {yes, no}) == yes;
  }

 private:
  int narg_;
  char** arg_;
  int next_;
};

}  // namespace millscale
