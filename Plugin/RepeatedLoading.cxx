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

/// The file of a plugin of this name that is loaded, in C++ or Python; empty if none is.
std::string FindThisPlugin()
{
  return FindLoadedFile([](vtkPVPluginTracker& tracker, unsigned int number)
    { return std::strcmp(tracker.GetPluginName(number), PluginName) == 0; });
}

void Warn(const std::string& text)
{
  auto* ranks = vtkMultiProcessController::GetGlobalController();
  if (!ranks || ranks->GetLocalProcessId() == 0)
  {
    vtkOutputWindow::GetInstance()->DisplayWarningText(text.c_str());
  }
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
  const std::string loaded = FindThisPlugin();
  if (!loaded.empty() && !std::filesystem::equivalent(file, loaded, error))
  {
    Warn(file.string() + ": is not loaded, since " + loaded + " is loaded already\n");
  }
  return !loaded.empty();
}

/// The plugin in Python, which is loaded already, cannot keep this one out: only what is loaded after it is asked.
void WarnOfPluginInPython()
{
  const std::string loaded = FindThisPlugin();
  if (!loaded.empty())
  {
    Warn(loaded + ": is loaded already, but from now on the plugin in C++ is used\n");
  }
}

/// At work while the plugin's library is loaded.
class RepeatedLoading
{
public:
  RepeatedLoading()
    : Callback(vtkPVPluginLoader::RegisterLoadPluginCallback(IsLoadedAlready))
  {
    WarnOfPluginInPython();
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
