#include "sweep/bundle.hpp"

#include "base/format.hpp"
#include "io/files.hpp"
#include "io/hash.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostBytes = std::size_t{1} << 30;

std::string runs_text(const SweepPlan& plan, int bundle) {
  constexpr std::size_t kDigits = 7;
  return padded(static_cast<std::size_t>(plan.first_of(bundle)) + 1, kDigits) + "-" +
         padded(static_cast<std::size_t>(plan.end_of(bundle)), kDigits);
}

std::string header(const SweepPlan& plan, int bundle, std::string_view csv) {
  return "# sweep " + plan.manifest.hash + " runs " + runs_text(plan, bundle) + " sha256 " + sha256(csv) + "\n";
}

}  // namespace

fs::path bundle_file(const SweepPlan& plan, const fs::path& folder, int bundle) {
  return folder / "results" / (runs_text(plan, bundle) + ".csv");
}

void write_bundle(const SweepPlan& plan, const fs::path& folder, int bundle, std::string_view csv) {
  write_file(bundle_file(plan, folder, bundle), header(plan, bundle, csv) + std::string(csv));
}

BundleText read_bundle(const SweepPlan& plan, const fs::path& folder, int bundle) {
  const fs::path file = bundle_file(plan, folder, bundle);
  if (!fs::exists(file)) return {};
  const std::string text = read_file(file, kMostBytes);
  const std::size_t end = std::min(text.find('\n'), text.size() - 1);
  if (text.empty()) return {std::nullopt, "is empty"};
  std::string csv = text.substr(end + 1);
  if (text.substr(0, end + 1) == header(plan, bundle, csv)) return {std::move(csv), ""};
  const bool foreign = text.starts_with("# sweep ") && text.find(plan.manifest.hash) == std::string::npos;
  return {std::nullopt, foreign ? "belongs to another sweep" : "is cut short or damaged"};
}

}  // namespace bayesctrl
