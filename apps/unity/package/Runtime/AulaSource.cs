using UnityEngine;

namespace Aula
{
    /// Numbers as the parameter of the spatializer.
    public enum AulaDirectivity
    {
        Omni,
        Subcardioid,
        Cardioid,
        Supercardioid,
        FigureOfEight,
        Talker,
        Loudspeaker
    }

    /// Beside an AudioSource that is spatialized: how loud it is, and where to.
    [RequireComponent(typeof(AudioSource))]
    public sealed class AulaSource : MonoBehaviour
    {
        /// 0: 1.0 is a sound pressure of 1.0 at a distance of 1 m.
        [Range(-80, 40)] public float gainDb;
        /// The front is the z axis.
        public AulaDirectivity directivity;

        AudioSource source;

        void Awake()
        {
            source = GetComponent<AudioSource>();
            source.spatialize = true;
            source.spatialBlend = 1;
        }

        // The engine has the parameters of a source only while it plays.
        void Update()
        {
            source.SetSpatializerFloat(0, gainDb);
            source.SetSpatializerFloat(1, (float)directivity);
        }
    }
}
