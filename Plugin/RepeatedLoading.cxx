// SPDX-License-Identifier: BSD-3-Clause
// Lets this plugin be loaded again without an error: by PV_PLUGIN_PATH or Auto Load, and by a script.
//
// ParaView knows a plugin by the path of its file. The second time its loader does nothing, which is
// right, but says that nothing is loaded, so the client of a server, or of pvbatch's ranks, reports a
// failure. Here the loader that is made for clients (XML/PluginLoader.xml) tells the truth. A second
// file of the plugin, whose classes would be there twice, is not loaded.
#include "vtkClientServerInterpreter.h"
#include "vtkClientServerInterpreterInitializer.h"
#include "vtkMultiProcessController.h"
#include "vtkOutputWindow.h"
#include "vtkPVPluginLoader.h"
#include "vtkPVPluginTracker.h"

#include <cstring>
#include <filesystem>
#include <string>
#include <system_error>

namespace
{

constexpr const char* PluginName = "ScalableIsosurface";

/// The file that a plugin was loaded from; empty if none fits. fits(number of the plugin).
template <typename Fits>
std::string FindLoadedFile(const Fits& fits)
{
  vtkPVPluginTracker* tracker = vtkPVPluginTracker::GetInstance();
  for (unsigned int number = 0; number < tracker->GetNumberOfPlugins(); ++number)
  {
    const char* file = tracker->GetPluginFileName(number);
    if (file && tracker->GetPluginLoaded(number) && fits(*tracker, number))
    {
      return file;
    }
  }
  return {};
}

/// Without a type of its own: clients call it by the name of its base class.
class TruthfulLoader : public vtkPVPluginLoader
{
public:
  static vtkObjectBase* Make(void*)
  {
    auto* loader = new TruthfulLoader;
    loader->InitializeObjectBase();
    return loader;
  }

  bool GetLoaded() override
  {
    const auto isIt = [this](vtkPVPluginTracker& tracker, unsigned int number)
    { return std::strcmp(tracker.GetPluginFileName(number), this->FileName) == 0; };
    return this->Loaded || (this->FileName && !FindLoadedFile(isIt).empty());
  }
};

/// Whether a file that is to be loaded is this plugin, which is there already.
bool IsLoadedAlready(const char* nameOrFile)
{
  const std::filesystem::path file(nameOrFile ? nameOrFile : "");
  std::error_code error;
  if (file.stem() != PluginName || !std::filesystem::is_regular_file(file, error))
  {
    return false;
  }
  const std::string loaded = FindLoadedFile([](vtkPVPluginTracker& tracker, unsigned int number)
    { return std::strcmp(tracker.GetPluginName(number), PluginName) == 0; });
  auto* ranks = vtkMultiProcessController::GetGlobalController();
  const bool isTold = !ranks || ranks->GetLocalProcessId() == 0;
  if (isTold && !loaded.empty() && !std::filesystem::equivalent(file, loaded, error))
  {
    const std::string text =
      file.string() + ": is not loaded, since " + loaded + " is loaded already\n";
    vtkOutputWindow::GetInstance()->DisplayWarningText(text.c_str());
  }
  return !loaded.empty();
}

/// At work while the plugin's library is loaded.
class RepeatedLoading
{
public:
  RepeatedLoading()
    : Callback(vtkPVPluginLoader::RegisterLoadPluginCallback(IsLoadedAlready))
  {
    vtkClientServerInterpreterInitializer::GetInitializer()->RegisterCallback(
      [](vtkClientServerInterpreter* interpreter)
      {
        interpreter->AddNewInstanceFunction(
          "vtkTruthfulPluginLoader", TruthfulLoader::Make, nullptr, nullptr);
      });
  }
  ~RepeatedLoading() { vtkPVPluginLoader::UnregisterLoadPluginCallback(this->Callback); }
  RepeatedLoading(const RepeatedLoading&) = delete;
  RepeatedLoading& operator=(const RepeatedLoading&) = delete;

private:
  int Callback;
};

const RepeatedLoading Instance;

} // namespace
