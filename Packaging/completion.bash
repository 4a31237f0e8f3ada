# Completion of blockvolume and edgeindex: the options that their own help names, and files.
_scalable_isosurface() {
  local cur prev words cword
  _init_completion || return
  case "$1" in
    *edgeindex)
      if [[ $cword -eq 1 && $cur != -* ]]; then
        COMPREPLY=($(compgen -W 'info verify decode' -- "$cur"))
        return
      fi
      ;;
  esac
  case "$prev" in
    --type) COMPREPLY=($(compgen -W 'int8 uint8 int16 uint16 int32 uint32 int64 uint64 float32 float64' -- "$cur")) ;;
    --compression) COMPREPLY=($(compgen -W 'none lz4 zstd' -- "$cur")) ;;
    --distribution) COMPREPLY=($(compgen -W 'greedy balanced random slab' -- "$cur")) ;;
    --unit) COMPREPLY=($(compgen -W 'm cm mm um nm angstrom inch' -- "$cur")) ;;
    --block-size) COMPREPLY=($(compgen -W '16 32 64' -- "$cur")) ;;
    *)
      if [[ $cur == -* && $1 == *edgeindex && $cword -gt 1 ]]; then
        COMPREPLY=($(compgen -W "$("$1" "${words[1]}" --help 2>/dev/null | grep -o -- '--[a-z-]*')" -- "$cur"))
      elif [[ $cur == -* ]]; then
        COMPREPLY=($(compgen -W "$("$1" --help 2>/dev/null | grep -o -- '--[a-z-]*' | sort -u)" -- "$cur"))
      else
        _filedir
      fi
      ;;
  esac
} &&
  complete -F _scalable_isosurface blockvolume edgeindex
