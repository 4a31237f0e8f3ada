# Seconds of the longest tests, roughly: ctest begins with them, so that none is left at the end. It knows by
# itself what it has run before; a build from nothing has not.
foreach(test IN ITEMS
    Plugin.SeriesOnAServerOf2RanksIsSavedAndLoaded=60
    Python.ImagesAreTheSameWithoutHiddenTriangles=60
    Rendering.ViewportsGiveTheSameImageOn4Ranks=60
    Plugin.ServerOfTwoRanksShowsTheSameAndLogsItsCost=60
    Plugin.SurfacesHaveTheStockImageOn1Ranks=60
    Plugin.ServerOfTwoRanksShowsTheWindowTheSame=50
    Plugin.FolderOfDicomOpensByClicking=50
    Plugin.GuiViewsSelectionsUndoAndFramesAreByHand=46
    Plugin.StackOfTiffIsSavedForPrinting=45
    Tools.SandboxFaultsOfALibraryAreErrors=45
    Plugin.OneFileOfPythonMakesTheSame_3=45
    Parallel.LackOfMemoryForMessagesIsToldByAllOn3Ranks=45
    Core.EdgeIndexWriteJob=45
    Plugin.GuiSavesTheFullSurfaceAndAsksAboutMemory=41
    Tools.hdf5ErrorsAndLists=40
    Core.Replicas=38
    Core.DiskFaultsAtEveryOperation=36
    Core.ForgedIndex=35
    Plugin.GuiTissuesOfACtAreAClickEach=35
    Parallel.RefinementIsThatOfAllRanksOn3Ranks=34
    Plugin.MetabufferViewShowsTheStockImageOn3Ranks=33
    Core.DiskFaultsOfWriting=32
    Core.EdgeIndexIslands=32
    Plugin.SurfacesHaveTheStockImageOn2Ranks=31)
  string(REPLACE "=" ";" test "${test}")
  list(GET test 0 name)
  list(GET test 1 seconds)
  set_tests_properties("${name}" PROPERTIES COST ${seconds})
endforeach()
