#pragma once

#include "diagnose/verdict/diagnose.hpp"
#include "io/emit.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"
#include "trial/cases.hpp"

namespace bayesctrl::testing {

/// The diagnosis of a trial's case, from its spec and recordings alone.
inline Diagnosis diagnosed(const trial::Case& hidden) {
  const io_examples::Folder folder;
  FileBatch batch;
  batch.add(folder.path() / "spec.yaml", to_yaml(hidden.spec));
  for (const auto& [file, csv] : hidden.files) batch.add(folder.path() / file, csv);
  batch.commit();
  return diagnose(read_diagnosis_spec(folder.path() / "spec.yaml")).diagnosis;
}

}  // namespace bayesctrl::testing
