# SPDX-License-Identifier: BSD-3-Clause
"""What all algorithms of the plugin have."""

import functools

import numpy
from vtkmodules import vtkCommonDataModel as model
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkWeakReference
from vtkmodules.vtkCommonExecutionModel import vtkDemandDrivenPipeline, vtkExecutive

from .. import _library
from ._arrays import to_vtk
from ._definitions import parse_default, PROPERTIES


def tell_error(text):
    """One line, in the window and the terminal."""
    vtkOutputWindow.GetInstance().DisplayErrorText(f"ERROR: ScalableIsosurface: {' '.join(text.split())}\n")


def find_ranks():
    """The ranks of ParaView; None if this process is alone."""
    from vtkmodules.vtkParallelCore import vtkMultiProcessController

    controller = vtkMultiProcessController.GetGlobalController()
    count = controller.GetNumberOfProcesses() if controller else 1
    if count == 1:
        return None
    rank = controller.GetLocalProcessId()

    def exchange(other, outgoing, incoming):
        steps = [(controller.Send, outgoing), (controller.Receive, incoming)]
        for step, memory in steps if rank < other else reversed(steps):
            if len(memory):
                step(to_vtk(memory), other, 7311)

    return _library.Ranks(rank, count, lambda mine, whole: controller.AllGather(to_vtk(mine), to_vtk(whole)), exchange)


def gather_text(ranks, text):
    """The texts of all ranks."""
    if ranks is None:
        return [text]
    mine = numpy.frombuffer(text.encode(errors="replace"), numpy.uint8)
    sizes = numpy.empty(8 * ranks.count, numpy.uint8)
    ranks.all_gather(numpy.array([len(mine)], numpy.int64).view(numpy.uint8), sizes)
    sizes = sizes.view(numpy.int64)
    largest = int(sizes.max())
    if largest == 0:
        return [""] * ranks.count
    padded = numpy.zeros(largest, numpy.uint8)
    padded[: len(mine)] = mine
    whole = numpy.empty(largest * ranks.count, numpy.uint8)
    ranks.all_gather(padded, whole)
    return [bytes(row[:size]).decode(errors="replace") for row, size in zip(whole.reshape(ranks.count, -1), sizes)]


class Failure(Exception):
    """What is told of the first rank that failed."""


#: In place of an error, where the user has stopped the work.
STOPPED = "The user has stopped it."


def list_commands(properties):
    """The functions that set properties of an algorithm, by their names."""
    commands = {}
    for element in properties:
        name, command = element.get("name"), element.get("command")
        if takes_value(element):
            is_repeated = element.get("repeat_command") == "1"
            commands[command] = functools.partial(put, name, is_repeated)
            commands[element.get("clean_command", "")] = functools.partial(resize, name, count=0)
            commands[element.get("set_number_command", "")] = functools.partial(resize, name)
    return commands


def takes_value(element):
    is_told = element.get("information_only") == "1" or element.tag in ("InputProperty", "Property")
    return element.get("command") and not is_told


def put(name, is_repeated, algorithm, *given):
    given = tuple("" if one is None else one for one in given)  # ParaView's "" of Python
    value = algorithm.values[name]
    if is_repeated and len(given) == 2:  # at an index, or of a name
        value[given[0]] = given[1]
    elif is_repeated:
        value.append(given[0])
    else:
        given = given[0] if len(given) == 1 else given
        if given == value:
            return
        algorithm.values[name] = given
    if name not in algorithm.unseen:
        algorithm.Modified()


def resize(name, algorithm, count):
    algorithm.values[name] = (algorithm.values[name] + [0.0] * count)[:count]
    algorithm.Modified()


COMMANDS = {name: list_commands(properties) for name, properties in PROPERTIES.items()}


def make_how(algorithm):
    """How calls run for an algorithm. Who has that keeps no algorithm: what an algorithm has of Python is beyond the
    garbage collector. A weakref does not do: VTK makes objects of Python anew for the same algorithm."""
    reference = vtkWeakReference()
    reference.Set(algorithm)

    def call(name, *given):
        there = reference.Get()
        return getattr(there, name)(*given) if there else 0

    return _library.How(algorithm.ranks, functools.partial(call, "advance"), functools.partial(call, "warn"))


class Algorithm(VTKPythonAlgorithmBase):
    """Has the properties of the XML in `values`, by their names. Nothing that an algorithm has may refer to it."""

    def __init__(self, inputs=0, outputs=1, **types):
        properties = PROPERTIES[type(self).__name__]
        self.values = {element.get("name"): parse_default(element) for element in properties if takes_value(element)}
        super().__init__(nInputPorts=inputs, nOutputPorts=outputs, **types)
        self.ranks = find_ranks()
        self.how = make_how(self)

    #: Whether a window has asked for news of this one (GetNeedsUpdate): not in a script that has just made it.
    polled = False

    def GetRefinement(self):
        """What the window of the plugin in C++ polls."""
        return (0.0,) * 9 + (-1.0,)

    #: Properties on which no output depends.
    unseen = ("CacheSize", "RefinementMemory")

    def __getattr__(self, name):
        try:
            return functools.partial(COMMANDS[type(self).__name__][name], self)
        except KeyError:
            raise AttributeError(f"{type(self).__name__} has no {name}") from None

    def advance(self, done):
        self.UpdateProgress(done)
        return int(self.CheckAbort() if hasattr(self, "CheckAbort") else self.GetAbortExecute())

    def warn(self, text):
        if self.ranks is None or self.ranks.rank == 0:
            vtkOutputWindow.GetInstance().DisplayWarningText(f"Warning: {text}\n")

    def agree(self, work):
        """Runs work of this rank. Raises a Failure on all ranks if one has an error. To be called before calls of the
        library that all ranks enter."""
        made, error = None, ""
        try:
            made = work()
        except Failure:  # which all ranks have
            raise
        except _library.Stopped:
            error = STOPPED
        except Exception as raised:  # pylint: disable=broad-except
            error = describe(raised)
        errors = [text for text in gather_text(self.ranks, error) if text]
        if errors:
            own = [text for text in errors if "another rank" not in text]
            raise Failure((own or errors)[0])
        return made

    def run(self, outputs, work):
        """Runs work of all ranks. What RequestData returns."""
        try:
            self.agree(work)
        except Failure as failure:
            return self.fail(outputs, str(failure))
        return 1

    def fail(self, outputs, error):
        """Tells an error, and nothing else; a stop is none."""
        stopped = error == STOPPED
        if not stopped and (self.ranks is None or self.ranks.rank == 0):
            tell_error(error)
        for port in range(outputs.GetNumberOfInformationObjects()):
            info = outputs.GetInformationObject(port)
            model.vtkDataObject.GetData(info).Initialize()
            if not stopped:
                info.Set(vtkDemandDrivenPipeline.DATA_NOT_GENERATED(), 1)
        if not stopped and outputs.GetNumberOfInformationObjects():
            silence(vtkExecutive.PRODUCER().GetExecutive(outputs.GetInformationObject(0)))
        return int(stopped)


def describe(error):
    """An exception as a sentence."""
    text = " ".join(str(error).split())
    if isinstance(error, OSError) and error.strerror:
        text = " ".join(error.strerror.split())
    if isinstance(error, (Failure, OSError, ValueError, MemoryError, RuntimeError, IndexError)) and text:
        return text
    return f"{type(error).__name__}: {text}"


def silence(executive):
    """Takes the next error of an executive, which repeats that there is one."""

    def take(caller, _, text):
        caller.RemoveObserver(tag)
        if "returned failure for request" not in text:
            vtkOutputWindow.GetInstance().DisplayErrorText(text)

    take.CallDataType = "string0"
    tag = executive.AddObserver("ErrorEvent", take)
