"""The list of all faults, by stage."""

from validation.mutants.fault import Fault
from validation.mutants.faults_detection import DETECTION
from validation.mutants.faults_lagrangian import LAGRANGIAN
from validation.mutants.faults_path import PATHS
from validation.mutants.faults_solve import SOLVERS
from validation.mutants.faults_start import STARTS
from validation.mutants.faults_weld import WELD
from validation.mutants.faults_zones import ZONE

FAULTS: list[Fault] = [*DETECTION, *ZONE, *SOLVERS, *LAGRANGIAN, *PATHS, *STARTS, *WELD]
