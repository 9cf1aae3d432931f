#!/usr/bin/env bash
# A map on a cluster with Slurm: submit with  sbatch scripts/slurm.sh CONFIG.toml [--set key.path=value ...]
# Submitted again after a time limit or a lost node, with any number of nodes, the run resumes.
#SBATCH --job-name=slipmap
#SBATCH --nodes=4
#SBATCH --ntasks-per-node=1
#SBATCH --cpus-per-task=64
#SBATCH --time=04:00:00
#SBATCH --signal=TERM@60
# One rank per node with a thread per core: only rank 0 writes, and fewer ranks are fewer messages.
# Build once on the login node:  cargo build --release --locked --features mpi --target-dir target/mpi
# Beyond a few hundred cores the writing rank is the bottleneck (docs, "clusters"): then rather one map per
# value of the slowest axis, as an array (sbatch --array=0-9), each with its own --set grid.epsilon=.. and
# output.path=..
set -euo pipefail
: "${1:?usage: sbatch scripts/slurm.sh CONFIG.toml [--set key.path=value ...]}"
cd "$SLURM_SUBMIT_DIR"
# Slurm starts the ranks itself if it knows this MPI (srun --mpi=list); otherwise its launcher does.
if srun --mpi=list 2>&1 | grep -q pmix; then
    launch=(srun --mpi=pmix --kill-on-bad-exit=1)
else
    launch=(mpirun --map-by "ppr:1:node:pe=$SLURM_CPUS_PER_TASK")
fi
exec "${launch[@]}" target/mpi/release/slipmap run "$@" --threads "$SLURM_CPUS_PER_TASK" --quiet --resume
