# Completion of blockvolume and edgeindex: the options and values that they name themselves, and files.
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
    --type | --compression | --distribution | --unit | --block-size)
      COMPREPLY=($(compgen -W "$(blockvolume --values-of "${prev#--}" 2>/dev/null)" -- "$cur"))
      ;;
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
