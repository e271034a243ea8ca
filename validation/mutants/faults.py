"""The list of all faults, by stage."""

from validation.mutants.fault import Fault
from validation.mutants.faults_certificate import CERTIFICATES
from validation.mutants.faults_gpu_step import GPU_STEP
from validation.mutants.faults_group_pivot import GROUP_PIVOT
from validation.mutants.faults_lagrangian import LAGRANGIAN
from validation.mutants.faults_loop import LOOPS
from validation.mutants.faults_proofs import PROOFS
from validation.mutants.faults_residuals import RESIDUAL
from validation.mutants.faults_solve import SOLVERS
from validation.mutants.faults_start import STARTS
from validation.mutants.faults_trees import TREE
from validation.mutants.faults_weld import WELD
from validation.mutants.faults_zones import ZONE

FAULTS: list[Fault] = [
    *PROOFS,
    *TREE,
    *ZONE,
    *SOLVERS,
    *RESIDUAL,
    *GROUP_PIVOT,
    *LAGRANGIAN,
    *LOOPS,
    *GPU_STEP,
    *CERTIFICATES,
    *STARTS,
    *WELD,
]
